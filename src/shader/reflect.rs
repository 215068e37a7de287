//! Reflection of a composed module through naga: what each entry point reads and writes.

use super::compose::{UnknownInclude, compose};
use super::members::{Members, members};
use crate::buffers;

/// How an entry point uses a buffer. Atomic operations that return or add count as both; an atomic store only writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// Its former content matters.
    pub read: bool,
    /// Its content changes.
    pub write: bool,
}

/// One buffer as an entry point binds it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binding {
    /// Name in the catalogue.
    pub name: String,
    /// `@group`.
    pub group: u32,
    /// `@binding`.
    pub binding: u32,
    /// Which part of the buffer, where it has several.
    pub part: u32,
    /// What the entry point does with it.
    pub access: Access,
    /// What it does with the members, if it is an array of structs.
    pub members: Option<Members>,
    /// A uniform, not a storage buffer.
    pub uniform: bool,
    /// Declared `read_write`.
    pub writable: bool,
}

/// A composed and validated module.
#[derive(Debug, Clone)]
pub struct Module {
    /// The complete WGSL text.
    pub text: String,
    entries: Vec<(String, Vec<Binding>, bool)>,
}

/// Why a module could not be made.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ShaderError {
    /// See [`UnknownInclude`].
    #[error(transparent)]
    Include(#[from] UnknownInclude),
    /// The text is not valid WGSL.
    #[error("{kind}: {message}")]
    Invalid {
        /// The stage.
        kind: String,
        /// naga's message with the place.
        message: String,
    },
    /// A variable's name is not in the catalogue of buffers.
    #[error("{kind}: `{name}` is bound, but the catalogue has no buffer of this name")]
    UnknownBuffer {
        /// The stage.
        kind: String,
        /// The variable.
        name: String,
    },
    /// An array that is used in a way of which [`super::split()`] knows nothing.
    #[error("`{name}` is larger than what a kernel can bind, and is not used element by element")]
    Whole {
        /// The variable.
        name: String,
    },
}

impl Module {
    /// Composes, validates and reflects a module; `kind` is for messages, `settings` the declaration of its uniform.
    ///
    /// # Errors
    /// If the module is not valid WGSL or binds something that the catalogue does not have.
    pub fn new(kind: &str, wgsl: &str, settings: &str) -> Result<Self, ShaderError> {
        let text = compose(wgsl, settings)?;
        let invalid = |message: String| ShaderError::Invalid { kind: kind.to_owned(), message };
        let module = naga::front::wgsl::parse_str(&text).map_err(|e| invalid(e.emit_to_string(&text)))?;
        let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all())
            .validate(&module)
            .map_err(|e| invalid(e.emit_to_string(&text)))?;
        let mut entries = Vec::new();
        for (index, entry) in module.entry_points.iter().enumerate() {
            let uses = info.get_entry_point(index);
            let (mut bindings, mut now) = (Vec::new(), false);
            let members = members(&module, &entry.function);
            for (handle, variable) in module.global_variables.iter() {
                now |= variable.space == naga::AddressSpace::Immediate && !uses[handle].is_empty();
                let (Some(place), usage) = (variable.binding, uses[handle]) else { continue };
                if usage.is_empty() {
                    continue;
                }
                let name = variable.name.clone().unwrap_or_default();
                if buffers::find(&name).is_none() && !name.starts_with("settings_") {
                    return Err(ShaderError::UnknownBuffer { kind: kind.to_owned(), name });
                }
                let atomic = usage.contains(naga::valid::GlobalUse::ATOMIC);
                bindings.push(Binding {
                    name,
                    group: place.group,
                    binding: place.binding,
                    part: 0,
                    access: Access {
                        read: atomic || usage.contains(naga::valid::GlobalUse::READ),
                        write: atomic || usage.contains(naga::valid::GlobalUse::WRITE),
                    },
                    members: members.get(&handle).copied(),
                    uniform: variable.space == naga::AddressSpace::Uniform,
                    writable: matches!(variable.space, naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE)),
                });
            }
            bindings.sort_by_key(|b| (b.group, b.binding));
            entries.push((entry.name.clone(), bindings, now));
        }
        Ok(Self { text, entries })
    }

    /// What an entry point binds; empty if there is none of this name.
    #[must_use]
    pub fn bindings(&self, entry_point: &str) -> &[Binding] {
        self.entries.iter().find(|(n, ..)| n == entry_point).map_or(&[], |(_, b, _)| b)
    }

    /// What the entry points bind, each of them anew.
    pub(super) fn all_bindings(&self) -> impl Iterator<Item = &Binding> {
        self.entries.iter().flat_map(|(_, bindings, _)| bindings)
    }

    /// Adds to each entry point that binds `name` what `more` makes of that binding.
    pub(super) fn extend(&mut self, name: &str, more: impl Fn(&Binding) -> Vec<Binding>) {
        for (_, bindings, _) in &mut self.entries {
            let added = bindings.iter().find(|b| b.name == name).map(&more);
            bindings.extend(added.into_iter().flatten());
        }
    }

    /// Whether an entry point uses `now`.
    #[must_use]
    pub fn uses_now(&self, entry_point: &str) -> bool {
        self.entries.iter().any(|(n, _, now)| n == entry_point && *now)
    }

    /// Names of the entry points.
    pub fn entry_points(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(n, ..)| n.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn access_tells_reads_from_writes() {
        let text = "
            @group(0) @binding(0) var<storage, read_write> moments: array<atomic<u32>>;
            @group(0) @binding(1) var<storage, read> particles: array<u32>;
            @compute @workgroup_size(1) fn clear() { atomicStore(&moments[0], 0u); }
            @compute @workgroup_size(1) fn add() { atomicAdd(&moments[0], particles[0]); }";
        let module = Module::new("test", text, "").expect("valid");
        let clear = module.bindings("clear");
        assert_eq!(clear.len(), 1);
        assert_eq!(clear[0].access, Access { read: false, write: true });
        let add = module.bindings("add");
        assert_eq!(add[0].access, Access { read: true, write: true });
        assert_eq!(add[1].access, Access { read: true, write: false });
    }

    #[test]
    fn a_variable_outside_the_catalogue_is_refused() {
        let text = "@group(0) @binding(0) var<storage, read> nonsense: array<u32>;
            @compute @workgroup_size(1) fn f() { _ = nonsense[0]; }";
        assert!(
            matches!(Module::new("test", text, ""), Err(ShaderError::UnknownBuffer { name, .. }) if name == "nonsense")
        );
    }
}
