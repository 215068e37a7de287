//! Parameters written once: a `params!` block is the Rust struct, its parser, its documentation and its JSON Schema.

/// A parameter's value after parsing, in the form in which a [`Field`] holds its default.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A real number.
    Float(f64),
    /// A whole number.
    Integer(i64),
    /// `true` or `false`.
    Boolean(bool),
    /// Free text, or one of a set of words.
    Text(String),
    /// A fixed number of real numbers.
    Vector(Vec<f64>),
    /// A fixed number of whole numbers.
    Counts(Vec<i64>),
    /// A list of words or texts.
    Words(Vec<String>),
    /// A list of rows of real numbers, all of one length.
    Rows(Vec<Vec<f64>>),
    /// A table of parameters.
    Table(Values),
}

/// What a parameter accepts.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A finite real number in `[min, max]`.
    Float {
        /// Smallest value accepted.
        min: f64,
        /// Largest value accepted.
        max: f64,
    },
    /// A whole number in `[min, max]`.
    Integer {
        /// Smallest value accepted.
        min: i64,
        /// Largest value accepted.
        max: i64,
    },
    /// `true` or `false`.
    Boolean,
    /// Free text.
    Text,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Exactly `len` finite real numbers, each in `[min, max]`.
    Vector {
        /// How many numbers.
        len: usize,
        /// Smallest value accepted.
        min: f64,
        /// Largest value accepted.
        max: f64,
    },
    /// Exactly `len` whole numbers, each in `[min, max]`.
    Counts {
        /// How many numbers.
        len: usize,
        /// Smallest value accepted.
        min: i64,
        /// Largest value accepted.
        max: i64,
    },
    /// A list of words, each from this set.
    Words(&'static [&'static str]),
    /// A list of free texts.
    Texts,
    /// A list of rows of `len` finite real numbers each.
    Rows {
        /// How many numbers a row has.
        len: usize,
    },
    /// A table with these parameters.
    Table {
        /// The table's own parameters.
        fields: fn() -> Vec<Field>,
    },
}

/// One parameter: everything that parsing, documentation and the schema need to know.
#[derive(Debug, Clone)]
pub struct Field {
    /// The key in the pipeline file.
    pub name: &'static str,
    /// What it means; the doc comment of the struct's field.
    pub doc: &'static str,
    /// Its unit, in a (cell edge), m (particle mass), kT, tau = a sqrt(m/kT); empty for pure numbers.
    pub unit: &'static str,
    /// What it accepts.
    pub kind: Kind,
    /// Its default; `None` where it is required or optional.
    pub default: Option<Value>,
    /// Whether it may be left out although it has no default.
    pub optional: bool,
}

/// Parsed values by key: complete for the [`Field`]s they were parsed against.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Values(Vec<(&'static str, Value)>);

impl Values {
    /// Every default of `fields`; required fields stay absent.
    #[must_use]
    pub fn defaults(fields: &[Field]) -> Self {
        Self(fields.iter().filter_map(|f| f.default.clone().map(|v| (f.name, v))).collect())
    }

    /// Sets or replaces one value.
    pub fn set(&mut self, name: &'static str, value: Value) {
        match self.0.iter_mut().find(|(n, _)| *n == name) {
            Some((_, v)) => *v = value,
            None => self.0.push((name, value)),
        }
    }

    /// The value of `name`, if present.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(n, _)| *n == name).map(|(_, v)| v)
    }

    /// All values in the order in which they were set.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.0.iter().map(|(n, v)| (*n, v))
    }
}

/// Conversion between a Rust type and [`Value`]; implemented for the types that `params!` fields may have.
pub trait Parameter: Sized {
    /// Reads the type from a value of the matching variant.
    fn from_value(value: &Value) -> Option<Self>;
    /// The value that reads back as `self`.
    fn to_value(&self) -> Value;
}

macro_rules! parameter {
    ($($type:ty, $variant:ident, $from:expr, $to:expr;)*) => {$(
        impl Parameter for $type {
            fn from_value(value: &Value) -> Option<Self> {
                match value { Value::$variant(v) => { #[allow(clippy::redundant_closure_call)] ($from)(v) } _ => None }
            }
            fn to_value(&self) -> Value { #[allow(clippy::redundant_closure_call)] Value::$variant(($to)(self)) }
        }
    )*};
}
parameter! {
    f64, Float, |v: &f64| Some(*v), |v: &f64| *v;
    u32, Integer, |v: &i64| u32::try_from(*v).ok(), |v: &u32| i64::from(*v);
    u64, Integer, |v: &i64| u64::try_from(*v).ok(), |v: &u64| i64::try_from(*v).unwrap_or(i64::MAX);
    bool, Boolean, |v: &bool| Some(*v), |v: &bool| *v;
    String, Text, |v: &String| Some(v.clone()), |v: &String| v.clone();
    Vec<String>, Words, |v: &Vec<String>| Some(v.clone()), |v: &Vec<String>| v.clone();
    [f64; 3], Vector, |v: &Vec<f64>| v.as_slice().try_into().ok(), |v: &[f64; 3]| v.to_vec();
    [f64; 4], Vector, |v: &Vec<f64>| v.as_slice().try_into().ok(), |v: &[f64; 4]| v.to_vec();
    [u32; 3], Counts, |v: &Vec<i64>| {
        let c: Vec<u32> = v.iter().filter_map(|n| u32::try_from(*n).ok()).collect();
        c.as_slice().try_into().ok()
    }, |v: &[u32; 3]| v.iter().map(|n| i64::from(*n)).collect();
}

impl<const N: usize> Parameter for Vec<[f64; N]> {
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Rows(rows) => rows.iter().map(|r| r.as_slice().try_into().ok()).collect(),
            _ => None,
        }
    }
    fn to_value(&self) -> Value {
        Value::Rows(self.iter().map(|r| r.to_vec()).collect())
    }
}

impl<P: Params> Parameter for P {
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Table(values) => Some(P::from_values(values)),
            _ => None,
        }
    }
    fn to_value(&self) -> Value {
        Value::Table(self.to_values())
    }
}

/// A struct declared by [`params!`](crate::params!).
pub trait Params: Sized + Clone + std::fmt::Debug {
    /// Its parameters in the order of the declaration.
    fn fields() -> Vec<Field>;
    /// The doc comment of the struct.
    fn summary() -> &'static str;
    /// Builds the struct; `values` must be complete for [`Params::fields`].
    ///
    /// # Panics
    /// If a required value is absent or has another variant than its field's [`Kind`]: the parser's checks rule that out.
    fn from_values(values: &Values) -> Self;
    /// The values from which [`Params::from_values`] makes `self` again.
    fn to_values(&self) -> Values;
}

/// Declares a parameter struct once.
///
/// ```
/// squirm::params! {
///     /// A rotation about a random axis.
///     pub struct Turn {
///         /// Rotation angle.
///         pub angle: f64 = 130.0; "degree", Float { min: 0.0, max: 180.0 };
///         /// A label, if any.
///         pub label: Option<String>; "", Text;
///         /// How often.
///         pub every: u32; "steps", Integer { min: 1, max: 1000 };
///     }
/// }
/// use squirm::params::Params;
/// assert_eq!(Turn::fields().len(), 3);
/// assert_eq!(Turn::fields()[0].doc, "Rotation angle.");
/// ```
///
/// A field with `= value` has a default, one of type `Option<T>` may be left out, any other is required. A default is
/// any expression that converts with `Into` into the field's type.
#[macro_export]
macro_rules! params {
    ($(#[doc = $summary:literal])* pub struct $name:ident { $(
        $(#[doc = $doc:literal])* pub $field:ident : $type:ty $(= $default:expr)? ; $unit:literal, $kind:ident $({ $($named:tt)* })? $(( $($plain:tt)* ))? ;
    )* }) => {
        $(#[doc = $summary])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name { $( $(#[doc = $doc])* pub $field: $type, )* }

        impl $crate::params::Params for $name {
            fn fields() -> Vec<$crate::params::Field> {
                vec![ $( $crate::params::Field {
                    name: stringify!($field),
                    doc: concat!($($doc),*).trim_ascii_start(),
                    unit: $unit,
                    kind: $crate::params::Kind::$kind $({ $($named)* })? $(( $($plain)* ))?,
                    default: $crate::params!(@default $type $(, $default)?),
                    optional: <$type as $crate::params::Slot>::OPTIONAL,
                }, )* ]
            }
            fn summary() -> &'static str { concat!($($summary),*).trim_ascii_start() }
            #[allow(unused_variables)]
            fn from_values(values: &$crate::params::Values) -> Self {
                Self { $( $field: <$type as $crate::params::Slot>::read(stringify!($field), values), )* }
            }
            #[allow(unused_mut)]
            fn to_values(&self) -> $crate::params::Values {
                let mut values = $crate::params::Values::default();
                $( <$type as $crate::params::Slot>::write(&self.$field, stringify!($field), &mut values); )*
                values
            }
        }
    };
    (@default $type:ty) => { None };
    (@default $type:ty, $default:expr) => {{
        let value: $type = ($default).into();
        Some($crate::params::Parameter::to_value(&value))
    }};
}

/// How a struct field meets [`Values`]: required or defaulted for `T`, optional for `Option<T>`.
pub trait Slot {
    /// Whether the parameter may be absent without a default.
    const OPTIONAL: bool;
    /// Reads the field.
    fn read(name: &'static str, values: &Values) -> Self;
    /// Writes the field.
    fn write(&self, name: &'static str, values: &mut Values);
}

impl<T: Parameter> Slot for T {
    const OPTIONAL: bool = false;
    fn read(name: &'static str, values: &Values) -> Self {
        let value = values.get(name).unwrap_or_else(|| panic!("parameter `{name}` was not parsed"));
        T::from_value(value).unwrap_or_else(|| panic!("parameter `{name}` has the wrong type: {value:?}"))
    }
    fn write(&self, name: &'static str, values: &mut Values) {
        values.set(name, self.to_value());
    }
}

impl<T: Parameter> Slot for Option<T> {
    const OPTIONAL: bool = true;
    fn read(name: &'static str, values: &Values) -> Self {
        values.get(name).and_then(T::from_value)
    }
    fn write(&self, name: &'static str, values: &mut Values) {
        if let Some(value) = self {
            values.set(name, value.to_value());
        }
    }
}
