//! Which members of the structs in an array an entry point reads and writes: two kernels that use different ones do not disturb each other.

use naga::{Block, Expression, Function, GlobalVariable, Handle, Statement, TypeInner};
use std::collections::{HashMap, HashSet};

/// Members by their numbers, as bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Members {
    /// Whose content matters.
    pub read: u64,
    /// Whose content changes.
    pub written: u64,
}

impl Members {
    /// Whether one of two writes what the other uses.
    #[must_use]
    pub fn clash(self, other: Self) -> bool {
        self.written & (other.read | other.written) != 0 || other.written & self.read != 0
    }
}

/// Where a pointer points.
#[derive(Clone, Copy)]
enum Place {
    Array(Handle<GlobalVariable>),
    Element(Handle<GlobalVariable>),
    Member(Handle<GlobalVariable>, u32),
}

type Found = HashMap<Handle<GlobalVariable>, Members>;

/// What an entry point does with each array of structs that it may touch.
pub(super) fn members(module: &naga::Module, entry: &Function) -> Found {
    let (mut found, mut known) = (Found::new(), HashSet::new());
    let mut called = looked_through(module, entry, &mut found);
    while let Some(next) = called.pop() {
        if known.insert(next) {
            called.extend(looked_through(module, &module.functions[next], &mut found));
        }
    }
    found
}

/// Enters what a function does; the functions that it calls.
fn looked_through(module: &naga::Module, function: &Function, found: &mut Found) -> Vec<Handle<Function>> {
    let mut places: HashMap<Handle<Expression>, Place> = HashMap::new();
    for (handle, expression) in function.expressions.iter() {
        let place = match expression {
            Expression::GlobalVariable(variable) if holds_structs(module, *variable) => Some(Place::Array(*variable)),
            Expression::Access { base, .. } => places.get(base).map(|p| within(*p, None)),
            Expression::AccessIndex { base, index } => places.get(base).map(|p| within(*p, Some(*index))),
            Expression::Load { pointer } => {
                note(places.get(pointer), found, (true, false));
                None
            }
            _ => None,
        };
        places.extend(place.map(|p| (handle, p)));
    }
    let mut called = Vec::new();
    each(&function.body, &mut |statement| match statement {
        Statement::Store { pointer, .. } => note(places.get(pointer), found, (false, true)),
        Statement::Atomic { pointer, .. } => note(places.get(pointer), found, (true, true)),
        Statement::Call { function, .. } => called.push(*function),
        _ => {}
    });
    called
}

fn holds_structs(module: &naga::Module, variable: Handle<GlobalVariable>) -> bool {
    let TypeInner::Array { base, .. } = module.types[module.global_variables[variable].ty].inner else { return false };
    matches!(&module.types[base].inner, TypeInner::Struct { members, .. } if members.len() <= 64)
}

fn within(place: Place, index: Option<u32>) -> Place {
    match (place, index) {
        (Place::Array(variable), _) => Place::Element(variable),
        (Place::Element(variable), Some(member)) => Place::Member(variable, member),
        (place, _) => place,
    }
}

fn note(place: Option<&Place>, found: &mut Found, (read, written): (bool, bool)) {
    let (variable, members) = match place {
        Some(Place::Array(variable) | Place::Element(variable)) => (variable, u64::MAX),
        Some(Place::Member(variable, member)) => (variable, 1 << member),
        None => return,
    };
    let entry = found.entry(*variable).or_default();
    entry.read |= if read { members } else { 0 };
    entry.written |= if written { members } else { 0 };
}

/// Every statement, those inside of others, too.
fn each(block: &Block, see: &mut dyn FnMut(&Statement)) {
    for statement in block {
        see(statement);
        match statement {
            Statement::Block(inner) => each(inner, see),
            Statement::If { accept, reject, .. } => [accept, reject].into_iter().for_each(|b| each(b, see)),
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| each(&case.body, see)),
            Statement::Loop { body, continuing, .. } => [body, continuing].into_iter().for_each(|b| each(b, see)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::shader::Module;

    #[test]
    fn members_are_told_apart_also_in_functions_that_are_called() {
        let text = "
            struct Two { a: vec3<f32>, b: u32, c: array<f32, 2> }
            @group(0) @binding(0) var<storage, read_write> squirmers: array<Two>;
            fn second(i: u32) -> u32 { if i > 2u { squirmers[i].c[1] = 3.0; } return squirmers[i].b; }
            @compute @workgroup_size(1) fn first() { squirmers[0].a.y += 1.0; }
            @compute @workgroup_size(1) fn others() { _ = second(1u); }
            @compute @workgroup_size(1) fn copies() { let s = squirmers[3]; squirmers[4].b = s.b; }
            @compute @workgroup_size(1) fn replaces() { squirmers[4] = Two(); }";
        let module = Module::new("test", text, "").expect("valid");
        let of = |point: &str| module.bindings(point)[0].members.expect("an array of structs");
        let bits = |point: &str| (of(point).read, of(point).written);
        assert_eq!(bits("first"), (1, 1));
        assert_eq!(bits("others"), (2, 4));
        assert_eq!(bits("copies"), (u64::MAX, 2));
        assert_eq!(bits("replaces"), (0, u64::MAX));
        assert!(!of("first").clash(of("others")) && !of("others").clash(of("first")));
        assert!(of("copies").clash(of("first")) && of("others").clash(of("replaces")));
    }

    #[test]
    fn arrays_of_other_things_have_none() {
        let text = "@group(0) @binding(0) var<storage, read_write> moments: array<vec4<u32>>;
            @compute @workgroup_size(1) fn f() { moments[0].x = 1u; }";
        assert_eq!(Module::new("test", text, "").expect("valid").bindings("f")[0].members, None);
    }
}
