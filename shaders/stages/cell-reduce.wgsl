// cell-reduce
