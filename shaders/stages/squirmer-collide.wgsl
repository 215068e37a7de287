// squirmer-collide
