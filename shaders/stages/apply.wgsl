// apply
