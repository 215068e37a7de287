// wall-ghosts
