// The operator of the cell whose particles an invocation moves on.
//!include operator

var<private> own_operator: Operator;

fn keep_operator(o: Operator) {
    own_operator = o;
}

fn operator_at(cell: u32) -> Operator {
    return own_operator;
}
