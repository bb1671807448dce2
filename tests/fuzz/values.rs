//! Numbers as nobody wants them.

use crate::random_views::Dice;

const NUMBERS: [f64; 18] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    1e-308,
    1e-160,
    f64::EPSILON,
    -1.0,
    1.0,
    1e15,
    -1e30,
    1e155,
    -1e160,
    f64::MAX,
    f64::MIN,
];

/// How often something is hostile: one in so many.
#[derive(Clone, Copy)]
pub struct Hostility(usize);

impl Hostility {
    pub fn drawn(dice: &mut Dice) -> Self {
        Self([4, 20, 100, 1000][dice.below(4)])
    }

    pub fn strikes(self, dice: &mut Dice) -> bool {
        dice.one_in(self.0)
    }

    /// The number, or another one.
    pub fn number(self, dice: &mut Dice, number: f64) -> f64 {
        if !self.strikes(dice) {
            return number;
        }
        match dice.below(4) {
            0 => -number,
            1 => number * 10_f64.powf(dice.between(-40.0, 40.0)),
            2 => f64::from_bits((dice.unit() * 2_f64.powi(53)) as u64 * 2049),
            _ => NUMBERS[dice.below(NUMBERS.len())],
        }
    }

    pub fn numbers<const N: usize>(self, dice: &mut Dice, numbers: [f64; N]) -> [f64; N] {
        numbers.map(|number| self.number(dice, number))
    }

    /// One of the constants 0 to `last`, or none of them.
    pub fn constant(self, dice: &mut Dice, last: i32) -> i32 {
        if self.strikes(dice) {
            [-1, last + 1, i32::MIN, i32::MAX, 255][dice.below(5)]
        } else {
            dice.below(last as usize + 1) as i32
        }
    }

    /// A count, or another one.
    pub fn count(self, dice: &mut Dice, count: usize) -> usize {
        if self.strikes(dice) {
            [0, count.saturating_sub(1), count + 1, usize::MAX, usize::MAX / 2 + 1, isize::MAX as usize / 64]
                [dice.below(6)]
        } else {
            count
        }
    }
}
