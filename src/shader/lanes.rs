//! Invocations that share the work for one element.

/// How many invocations share the work for one cell, and whether they know of the others of their subgroup.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Lanes {
    /// One: what suits a CPU.
    #[default]
    One,
    /// Four neighbours of a subgroup: more loads under way at a time, which suits a GPU.
    Four,
}

impl Lanes {
    /// Their number.
    #[must_use]
    pub fn count(self) -> u64 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }

    /// WGSL that includes `lanes` for one invocation, for this many.
    #[must_use]
    pub fn chosen(self, wgsl: &str) -> String {
        match self {
            Self::One => wgsl.to_owned(),
            Self::Four => wgsl.replace("//!include lanes\n", "//!include lanes-four\n"),
        }
    }
}
