//! The truth in f64: which parts of a ray see a light, how much light comes
//! from them, and the image that follows.
//!
//! Nothing here calls `lighting`'s mathematics: it reads the plain numbers of
//! rays, emitters, media and triangles and starts again from the definitions.
//!
//! | module | question | answer |
//! |---|---|---|
//! | [`visibility`] | which parts of a ray see a light? | exact intervals |
//! | [`airlight`] | how much light comes from them? | adaptive quadrature with an error bound |
//! | [`segment`] | how much from a part of a ray that is given by its own four lengths? | the same, to any shortness |
//! | [`closed_form`] | the same where a formula exists | checks the quadrature |
//! | [`image`] | the reference image | the product of the first two, summed over lights |
//! | [`translucent`] | how much gets through hair and smoke? | the exact transmittance to a point, and the image behind them |

pub mod airlight;
mod blockers;
pub mod closed_form;
mod fog;
pub mod image;
mod lamp;
mod line;
mod quadrature;
pub mod segment;
mod shades;
mod span;
pub mod translucent;
pub mod visibility;

pub use fog::{Fog, phase};
pub use lamp::{Lamp, PointLamp, Sun};
pub use line::Line;
pub use span::Span;
