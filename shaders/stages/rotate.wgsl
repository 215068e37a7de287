// rotate
