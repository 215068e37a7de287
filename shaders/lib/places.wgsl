// Whether any stage asks for the sums over positions in a cell; without them the collision knows no angular momentum.
override PLACES: bool = true;
