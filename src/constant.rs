//! Constants that were judged rather than derived, by name, so that each one's influence on the results can be
//! measured: `cargo run --release --features sensitivity --example sensitivity`, and `sensitivity_scenes` for those of detection.

/// A constant with its place in the source and its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// Module and name.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
    /// What tells it from all others, never 0.
    #[cfg(feature = "sensitivity")]
    pub number: u64,
}

impl Constant {
    /// The value.
    #[cfg(not(feature = "sensitivity"))]
    #[inline(always)]
    #[must_use]
    pub const fn get(self) -> f64 {
        self.value
    }

    /// The value as a number of things.
    #[cfg(not(feature = "sensitivity"))]
    #[inline(always)]
    #[must_use]
    pub const fn count(self) -> usize {
        self.value as usize
    }
}

/// Defines constants, each with its value and its unit, and the list of them. A value that follows from that of another constant is
/// written by it (`2.0 * OTHER.value`); each is scaled alone all the same.
macro_rules! constants {
    ($($(#[$meta:meta])* $vis:vis $name:ident = $value:expr, $unit:literal;)*) => {
        $(
            $(#[$meta])*
            $vis const $name: $crate::constant::Constant = $crate::constant::Constant {
                name: concat!(module_path!(), "::", stringify!($name)),
                value: $value,
                unit: $unit,
                #[cfg(feature = "sensitivity")]
                number: $crate::constant::number(concat!(module_path!(), "::", stringify!($name))),
            };
        )*

        /// The constants of this file.
        #[cfg(feature = "sensitivity")]
        pub(crate) const CONSTANTS: &[$crate::constant::Constant] = &[$($name),*];
    };
}

/// A number for a name, never 0 (Fowler, Noll and Vo's hash).
#[cfg(feature = "sensitivity")]
pub(crate) const fn number(name: &str) -> u64 {
    let bytes = name.as_bytes();
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    let mut k = 0;
    while k < bytes.len() {
        hash = (hash ^ bytes[k] as u64).wrapping_mul(0x0100_0000_01b3);
        k += 1;
    }
    hash | 1
}

#[cfg(feature = "sensitivity")]
mod scaled {
    use super::Constant;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// Which constant is scaled (0 for none), and the bits of its factor.
    static SCALED: AtomicU64 = AtomicU64::new(0);
    static FACTOR: AtomicU64 = AtomicU64::new(0);

    impl Constant {
        /// The factor on it.
        #[inline]
        fn factor(self) -> f64 {
            if SCALED.load(Ordering::Relaxed) == self.number {
                f64::from_bits(FACTOR.load(Ordering::Relaxed))
            } else {
                1.0
            }
        }

        /// The value, scaled where it is this one's turn.
        #[inline]
        #[must_use]
        pub fn get(self) -> f64 {
            self.value * self.factor()
        }

        /// The value as a number of things, scaled where it is this one's turn, by one at least.
        #[inline]
        #[must_use]
        pub fn count(self) -> usize {
            let factor = self.factor();
            let value = self.value * factor;
            (if factor < 1.0 { value.floor() } else { value.ceil() }) as usize
        }

        /// Scales this constant and no other, for all threads.
        pub fn scale(self, factor: f64) {
            FACTOR.store(factor.to_bits(), Ordering::Relaxed);
            SCALED.store(self.number, Ordering::Relaxed);
        }

        /// Scales none.
        pub fn reset() {
            SCALED.store(0, Ordering::Relaxed);
        }
    }
}
