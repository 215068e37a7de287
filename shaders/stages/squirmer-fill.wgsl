// squirmer-fill
