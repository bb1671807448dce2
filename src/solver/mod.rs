//! Minimisation: Levenberg–Marquardt on the normal equations, and a tall least-squares solve as its reference.

mod least_squares;
mod levenberg_marquardt;

pub use least_squares::{LeastSquares, Rank};
pub use levenberg_marquardt::{Convergence, Domain, Iteration, IterationLimits, Termination, minimise};
