//! The truth in f64: which parts of a ray see a light, how much light comes
//! from them, and the image that follows.
//!
//! Nothing here calls the mathematics of the crates: it reads the plain numbers
//! of rays, emitters, media and triangles and starts again from the
//! definitions. Modules marked with `scene` need that feature.
//!
//! | module | feature | question | answer |
//! |---|---|---|---|
//! | [`quadrature`] | | what is the integral of a function of three channels? | an estimate with an error bound |
//! | [`segment`] | | how much light comes from a part of a ray that is given by its own four lengths? | the integral, to any shortness |
//! | [`closed_form`] | | the same where a formula exists | checks the quadrature |
//! | `visibility` | `scene` | which parts of a ray see a light? | exact intervals |
//! | `coats` | `scene` | how much gets through masks and what is see-through? | the exact share at a point |
//! | `airlight` | `scene` | how much light comes from them? | adaptive quadrature with an error bound |
//! | `image` | `scene` | the reference image | the product of the last two, summed over lights |
//! | `area` | `scene` | the same of area lights | adaptive cubature over the light of the image of each of its points |
//! | `map_runs` | `scene` | which parts of a ray does a shadow map show lit? | its texels, one by one |
//! | `surface` | `scene` | how much light does a surface receive by way of the fog? what is seen of an environment? | nested adaptive quadrature |
//! | `media` | `scene` | how much light comes along a ray through smoke and fog that are not uniform? | adaptive quadrature with exact optical depths |
//! | `media_image` | `scene` | the same for all rays of a picture | quadrature refined until n and 2n nodes agree |
//! | `translucent` | `scene` | how much gets through hair and smoke? | the exact transmittance to a point, and the image behind them |

#[cfg(feature = "scene")]
pub mod airlight;
#[cfg(feature = "scene")]
pub mod area;
#[cfg(feature = "scene")]
mod blockers;
pub mod closed_form;
#[cfg(feature = "scene")]
pub mod coats;
#[cfg(feature = "scene")]
mod fog;
#[cfg(feature = "scene")]
pub mod image;
#[cfg(feature = "scene")]
mod lamp;
#[cfg(feature = "scene")]
mod line;
#[cfg(feature = "scene")]
pub mod map_runs;
#[cfg(feature = "scene")]
pub mod media;
#[cfg(feature = "scene")]
pub mod media_image;
mod phase;
pub mod quadrature;
pub mod segment;
#[cfg(feature = "scene")]
mod shades;
#[cfg(feature = "scene")]
mod span;
#[cfg(feature = "scene")]
pub mod surface;
#[cfg(feature = "scene")]
pub mod translucent;
#[cfg(feature = "scene")]
pub mod visibility;

#[cfg(feature = "scene")]
pub use fog::Fog;
#[cfg(feature = "scene")]
pub use lamp::{Lamp, PointLamp, Sun};
#[cfg(feature = "scene")]
pub use line::Line;
pub use phase::Phase;
#[cfg(feature = "scene")]
pub use span::Span;
