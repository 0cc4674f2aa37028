//! The two precisions.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`: what a formula needs that is written once for both.
pub trait Real:
    sealed::Sealed
    + Copy
    + PartialOrd
    + Debug
    + Default
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + From<f32>
    + Into<f64>
{
    /// The nearest number of this precision.
    fn of(value: f64) -> Self;

    /// The square root.
    fn square_root(self) -> Self;

    /// The number without its sign.
    fn absolute(self) -> Self;

    /// `e^x`.
    fn exponential(self) -> Self;

    /// `e^x − 1` without cancellation.
    fn exponential_minus_one(self) -> Self;

    /// Whether it is an infinity.
    fn is_infinite(self) -> bool;
}

impl Real for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }

    fn square_root(self) -> Self {
        self.sqrt()
    }

    fn absolute(self) -> Self {
        self.abs()
    }

    fn exponential(self) -> Self {
        self.exp()
    }

    fn exponential_minus_one(self) -> Self {
        self.exp_m1()
    }

    fn is_infinite(self) -> bool {
        self.is_infinite()
    }
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn square_root(self) -> Self {
        self.sqrt()
    }

    fn absolute(self) -> Self {
        self.abs()
    }

    fn exponential(self) -> Self {
        self.exp()
    }

    fn exponential_minus_one(self) -> Self {
        self.exp_m1()
    }

    fn is_infinite(self) -> bool {
        self.is_infinite()
    }
}
