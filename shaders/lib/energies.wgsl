// Whether any stage asks for the energies of cells.
override ENERGIES: bool = true;
