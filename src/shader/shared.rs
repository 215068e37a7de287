//! Structs written once for Rust and WGSL: `shared!` emits both, and a test compares their layouts through naga.

/// A struct that exists in Rust and WGSL with one layout.
pub trait Shared: bytemuck::Pod {
    /// Its name in both languages.
    const NAME: &'static str;
    /// Its WGSL declaration.
    const WGSL: &'static str;
    /// Names and byte offsets of its fields in Rust, for the layout test.
    fn offsets() -> Vec<(&'static str, usize)>;
}

/// Declares a struct for Rust and WGSL at once. Field types are `f32 u32 i32 vec3f vec3u vec3i vec4f vec4u`; a `vec3` must
/// be followed by a scalar (a `pad` if nothing else), so that both languages place the next field alike.
#[macro_export]
macro_rules! shared {
    ($(#[doc = $summary:literal])* pub struct $name:ident { $( $(#[doc = $doc:literal])* $field:ident : $type:ident, )* }) => {
        $(#[doc = $summary])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable, Default)]
        pub struct $name { $( $(#[doc = $doc])* pub $field: $crate::shared!(@rust $type), )* }

        impl $crate::shader::shared::Shared for $name {
            const NAME: &'static str = stringify!($name);
            const WGSL: &'static str = concat!(
                "struct ", stringify!($name), " {\n",
                $( "    ", stringify!($field), ": ", $crate::shared!(@wgsl $type), ",\n", )*
                "}\n"
            );
            fn offsets() -> Vec<(&'static str, usize)> {
                vec![ $( (stringify!($field), std::mem::offset_of!($name, $field)), )* ]
            }
        }
    };
    (@rust f32) => { f32 }; (@rust u32) => { u32 }; (@rust i32) => { i32 };
    (@rust vec3f) => { [f32; 3] }; (@rust vec3u) => { [u32; 3] }; (@rust vec3i) => { [i32; 3] };
    (@rust vec4f) => { [f32; 4] }; (@rust vec4u) => { [u32; 4] };
    (@wgsl f32) => { "f32" }; (@wgsl u32) => { "u32" }; (@wgsl i32) => { "i32" };
    (@wgsl vec3f) => { "vec3<f32>" }; (@wgsl vec3u) => { "vec3<u32>" }; (@wgsl vec3i) => { "vec3<i32>" };
    (@wgsl vec4f) => { "vec4<f32>" }; (@wgsl vec4u) => { "vec4<u32>" };
}
