// Whether the box is a slit; without walls the kernels leave out what they need for them.
override WALLS: bool = true;
