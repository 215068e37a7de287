// sort-reorder
