//! Stored samples: one enum over the element types, one trait for generic code over them.

use bytemuck::Pod;

/// The type of a stored sample. Files keep theirs; nothing is widened on reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl SampleType {
    /// Every type, in the order of the enum.
    pub const ALL: [SampleType; 8] = [
        SampleType::U8,
        SampleType::I8,
        SampleType::U16,
        SampleType::I16,
        SampleType::U32,
        SampleType::I32,
        SampleType::F32,
        SampleType::F64,
    ];

    /// Bytes per sample.
    pub const fn size(self) -> usize {
        match self {
            SampleType::U8 | SampleType::I8 => 1,
            SampleType::U16 | SampleType::I16 => 2,
            SampleType::U32 | SampleType::I32 | SampleType::F32 => 4,
            SampleType::F64 => 8,
        }
    }

    /// The name used on the command line, in scenes and in messages: `u8` … `f64`.
    pub const fn name(self) -> &'static str {
        match self {
            SampleType::U8 => "u8",
            SampleType::I8 => "i8",
            SampleType::U16 => "u16",
            SampleType::I16 => "i16",
            SampleType::U32 => "u32",
            SampleType::I32 => "i32",
            SampleType::F32 => "f32",
            SampleType::F64 => "f64",
        }
    }

    /// The type called `name`: `u8`, `uint8`, `uchar`, `float`, `double`, … in any case.
    pub fn from_name(name: &str) -> Option<SampleType> {
        Some(match name.to_ascii_lowercase().as_str() {
            "u8" | "uint8" | "uchar" | "byte" => SampleType::U8,
            "i8" | "int8" | "char" | "schar" => SampleType::I8,
            "u16" | "uint16" | "ushort" => SampleType::U16,
            "i16" | "int16" | "short" => SampleType::I16,
            "u32" | "uint32" | "uint" => SampleType::U32,
            "i32" | "int32" | "int" => SampleType::I32,
            "f32" | "float32" | "float" => SampleType::F32,
            "f64" | "float64" | "double" => SampleType::F64,
            _ => return None,
        })
    }

    /// Whether the type holds whole numbers only.
    pub const fn is_integer(self) -> bool {
        !matches!(self, SampleType::F32 | SampleType::F64)
    }
}

impl std::fmt::Display for SampleType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// An element type that a grid can store.
pub trait Sample: Pod + PartialOrd + Send + Sync + std::fmt::Debug + 'static {
    /// The run-time name of this type.
    const TYPE: SampleType;
    /// Exact for every type.
    fn to_f64(self) -> f64;
    /// Rounds to nearest for u32, i32 and f64.
    fn to_f32(self) -> f32;
    /// The nearest representable sample; NaN becomes 0 for whole-number types, out of range is clamped.
    fn from_f64(value: f64) -> Self;
    /// Puts a vector of this type into the enum.
    fn wrap(samples: Vec<Self>) -> Samples;
    /// The samples if they are of this type.
    fn of(samples: &Samples) -> Option<&[Self]>;
    /// The same number with its bytes in the opposite order.
    fn swapped(self) -> Self;
}

macro_rules! samples {
    ($($variant:ident $type:ident $from:expr, $swap:expr;)*) => {
        /// The samples of one grid, x fastest: index = x + nx·(y + ny·z).
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs)]
        pub enum Samples { $($variant(Vec<$type>)),* }

        $(impl Sample for $type {
            const TYPE: SampleType = SampleType::$variant;
            #[inline(always)]
            fn to_f64(self) -> f64 { self as f64 }
            #[inline(always)]
            fn to_f32(self) -> f32 { self as f32 }
            #[inline(always)]
            fn from_f64(value: f64) -> Self { let from: fn(f64) -> $type = $from; from(value) }
            fn wrap(samples: Vec<Self>) -> Samples { Samples::$variant(samples) }
            fn of(samples: &Samples) -> Option<&[Self]> {
                match samples { Samples::$variant(s) => Some(s), _ => None }
            }
            #[inline(always)]
            fn swapped(self) -> Self { let swap: fn($type) -> $type = $swap; swap(self) }
        })*

        impl Samples {
            /// No samples of a type, to be filled.
            pub fn new(sample_type: SampleType) -> Samples {
                match sample_type { $(SampleType::$variant => Samples::$variant(Vec::new())),* }
            }
            /// The element type.
            pub fn sample_type(&self) -> SampleType {
                match self { $(Samples::$variant(_) => SampleType::$variant),* }
            }
            /// Number of samples.
            pub fn len(&self) -> usize {
                match self { $(Samples::$variant(s) => s.len()),* }
            }
            /// The sample at `index` as f64, which is exact for every type.
            ///
            /// # Panics
            /// If `index` is not less than [`Samples::len`].
            pub fn get(&self, index: usize) -> f64 {
                match self { $(Samples::$variant(s) => s[index].to_f64()),* }
            }
            /// The samples as bytes in the order of this machine.
            pub fn as_bytes(&self) -> &[u8] {
                match self { $(Samples::$variant(s) => bytemuck::cast_slice(s)),* }
            }
        }
    };
}

samples! {
    U8 u8 |v| v.round() as u8, |v| v;
    I8 i8 |v| v.round() as i8, |v| v;
    U16 u16 |v| v.round() as u16, |v| v.swap_bytes();
    I16 i16 |v| v.round() as i16, |v| v.swap_bytes();
    U32 u32 |v| v.round() as u32, |v| v.swap_bytes();
    I32 i32 |v| v.round() as i32, |v| v.swap_bytes();
    F32 f32 |v| v as f32, |v| f32::from_bits(v.to_bits().swap_bytes());
    F64 f64 |v| v, |v| f64::from_bits(v.to_bits().swap_bytes());
}

impl Samples {
    /// Whether there is no sample. A grid in a [`Volume`](crate::Volume) always has one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Runs the body with a name bound to the typed vector inside a [`Samples`].
///
/// ```
/// use strahl_volume::{Sample, Samples, with_samples};
/// let samples = Samples::I16(vec![-3, 7]);
/// let sum: f64 = with_samples!(&samples, s => s.iter().map(|v| v.to_f64()).sum());
/// assert_eq!(sum, 4.0);
/// ```
#[macro_export]
macro_rules! with_samples {
    ($samples:expr, $name:ident => $body:expr) => {
        match $samples {
            $crate::Samples::U8($name) => $body,
            $crate::Samples::I8($name) => $body,
            $crate::Samples::U16($name) => $body,
            $crate::Samples::I16($name) => $body,
            $crate::Samples::U32($name) => $body,
            $crate::Samples::I32($name) => $body,
            $crate::Samples::F32($name) => $body,
            $crate::Samples::F64($name) => $body,
        }
    };
}

/// Runs the body with a name bound to the type of samples that a [`SampleType`] stands for.
macro_rules! with_type {
    ($sample_type:expr, $name:ident => $body:expr) => {
        $crate::samples::with_type!(
            @ $sample_type, $name, $body,
            U8 u8 I8 i8 U16 u16 I16 i16 U32 u32 I32 i32 F32 f32 F64 f64
        )
    };
    (@ $sample_type:expr, $name:ident, $body:expr, $($variant:ident $type:ident)*) => {
        match $sample_type {
            $($crate::SampleType::$variant => {
                type $name = $type;
                $body
            })*
        }
    };
}
pub(crate) use with_type;
