//! Scenes that need no file.
//!
//! [`Embedded`] lists them. Each is made from a seed and brings a camera,
//! lights and a medium; the same seed gives the same scene, bit for bit. All
//! meshes are closed and counter-clockwise seen from outside.
//!
//! What makes one scene harder than another is measured by
//! [`figures`](crate::statistics::figures).
//!
//! ```
//! use scene::procedural::Embedded;
//! use scene::Geometry;
//!
//! let fence = Embedded::from_name("fence").ok_or("no such scene")?;
//! let scene = fence.build(1);
//! let geometry = Geometry::new(&scene)?;
//! assert!(scene.camera.is_some() && geometry.triangles().len() > 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod area_light;
mod city;
mod coil;
mod fence;
mod hairball;
mod in_smoke;
mod landscape;
mod pergola;
pub(crate) mod primitives;
mod random;
mod screen;
mod smoke;
mod stage;
mod stand_ins;
mod stiff;
#[cfg(test)]
mod tests;
mod textured_spot;
mod translucent;

pub use smoke::{Puff, smoke_puffs};
pub use stand_ins::StandIn;
pub use translucent::{ponytail, smoke_grid, smoke_particles};

use crate::Scene;

/// A scene that needs no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Embedded {
    /// A city seen from its park against a low sun: more than 10,000 closed
    /// solids, many of which intersect, and poles thinner than a texel.
    City,
    /// Fractal mountains, closed by sides and a bottom, in bluish haze that
    /// fills a box; the sun is low.
    Landscape,
    /// Strands curling out of a centre, lit by a point between them.
    Hairball,
    /// Three columns of [`smoke_puffs`] against a spotlight, each puff a small
    /// opaque ball.
    Smoke,
    /// A ball in the coloured light of a window-like cookie.
    TexturedSpot,
    /// A knotted, ribbed tube of about 100,000 triangles under a glowing
    /// rectangle.
    AreaLight,
    /// Wide beams under a glowing rectangle, whose soft shadows take about half of
    /// its light.
    Pergola,
    /// Plates and balls under a screen with a test card: soft shadows in colours.
    Screen,
    /// A spring around a lamp.
    Coil,
    /// Pickets and wires between the eye and a lamp.
    Fence,
    /// Hard on numbers rather than on the eye: optical depth 50 to 100 across
    /// the medium, one light a few millimetres from the eye, another 10 km
    /// away, and walls that rays and light meet at grazing angles.
    Stiff,
    /// The columns of smoke as they are, a plume on a grid and a ponytail:
    /// all of them let a part of the light through.
    Translucent,
    /// Sunlight through the window of a furnished room full of smoke (figure 3 of Salvi et
    /// al. 2010), and a lamp.
    SmokeRoom,
    /// Three columns of smoke over a yard at a low sun (their figure 4), in fog that thins
    /// out with altitude.
    SmokeColumns,
    /// A ponytail in rising smoke against a spotlight (their figures 1 and 5).
    SmokeHair,
    /// The strands of [`Embedded::Hairball`] under a glowing rectangle.
    HairballPanel,
    /// The park of [`Embedded::City`] under a glowing rectangle, as of a stadium.
    CityPanel,
    /// [`Embedded::City`] with cars on the streets by the park and balloons above it, which
    /// are [dynamic](crate::Instance::dynamic).
    Traffic,
}

impl Embedded {
    /// Every scene that any comparison can take, in the order in which they are listed
    /// to users.
    pub const ALL: [Self; 11] = [
        Self::City,
        Self::Landscape,
        Self::Hairball,
        Self::Smoke,
        Self::TexturedSpot,
        Self::AreaLight,
        Self::Pergola,
        Self::Coil,
        Self::Fence,
        Self::Stiff,
        Self::Translucent,
    ];

    /// Scenes of smoke that is seen, listed to users behind the others: only the methods of
    /// heterogeneous media are compared on them.
    pub const IN_SMOKE: [Self; 3] = [Self::SmokeRoom, Self::SmokeColumns, Self::SmokeHair];

    /// Scenes in which something moves, listed to users behind those.
    pub const MOVING: [Self; 1] = [Self::Traffic];

    /// Scenes whose reference takes minutes: an area light over very many triangles, or
    /// one with a picture on it. They have names as all others do, and are in no list of
    /// them.
    pub const LARGE: [Self; 3] = [Self::Screen, Self::HairballPanel, Self::CityPanel];

    /// The name by which users ask for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::City => "city",
            Self::Landscape => "landscape",
            Self::Hairball => "hairball",
            Self::Smoke => "smoke",
            Self::TexturedSpot => "textured-spot",
            Self::AreaLight => "area-light",
            Self::Pergola => "pergola",
            Self::Screen => "screen",
            Self::Coil => "coil",
            Self::Fence => "fence",
            Self::Stiff => "stiff",
            Self::Translucent => "translucent",
            Self::SmokeRoom => "smoke-room",
            Self::SmokeColumns => "smoke-columns",
            Self::SmokeHair => "smoke-hair",
            Self::HairballPanel => "hairball-panel",
            Self::CityPanel => "city-panel",
            Self::Traffic => "traffic",
        }
    }

    /// Those that are listed to users.
    pub fn listed() -> impl Iterator<Item = Self> {
        Self::ALL
            .into_iter()
            .chain(Self::IN_SMOKE)
            .chain(Self::MOVING)
    }

    /// The scene of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        let mut all = Self::listed().chain(Self::LARGE);
        all.find(|scene| scene.name() == name)
    }

    /// One line for a list of scenes.
    pub const fn description(self) -> &'static str {
        match self {
            Self::City => "10,000 closed solids, trees and thin poles against a low sun",
            Self::Landscape => "fractal mountains in a box of bluish haze, low sun",
            Self::Hairball => "1,500 curling strands around a point light",
            Self::Smoke => "three columns of small opaque puffs against a spotlight",
            Self::TexturedSpot => "a ball in the coloured cone of a spotlight with a cookie",
            Self::AreaLight => "a dense knotted tube under a rectangular area light",
            Self::Pergola => "wide beams under an area light: strong soft shadows",
            Self::Screen => "plates and balls under a screen that shows a test card",
            Self::Coil => "a spring around a point light",
            Self::Fence => "pickets and wires in front of a point light",
            Self::Stiff => "dense fog, a light at the eye and one 10 km away, grazing walls",
            Self::Translucent => "smoke and hair that let a part of a spotlight through",
            Self::SmokeRoom => "sun through the window of a furnished room full of smoke",
            Self::SmokeColumns => "three columns of smoke at a low sun in fog that thins out",
            Self::SmokeHair => "a ponytail in rising smoke against a spotlight",
            Self::HairballPanel => "1,500 curling strands under an area light",
            Self::CityPanel => "the park of the city under a large area light",
            Self::Traffic => "the city with cars and balloons that move",
        }
    }

    /// Makes the scene. Any seed will do; 1 is the one that reports use.
    pub fn build(self, seed: u64) -> Scene {
        let stage = stage::Stage::new(self.name());
        match self {
            Self::City => city::build(stage, seed),
            Self::Landscape => landscape::build(stage, seed),
            Self::Hairball => hairball::build(stage, seed),
            Self::Smoke => smoke::build(stage, seed),
            Self::TexturedSpot => textured_spot::build(stage, seed),
            Self::AreaLight => area_light::build(stage, seed),
            Self::Pergola => pergola::build(stage, seed),
            Self::Screen => screen::build(stage, seed),
            Self::Coil => coil::build(stage, seed),
            Self::Fence => fence::build(stage, seed),
            Self::Stiff => stiff::build(stage, seed),
            Self::Translucent => translucent::build(stage, seed),
            Self::SmokeRoom => in_smoke::room(stage, seed),
            Self::SmokeColumns => in_smoke::columns(stage, seed),
            Self::SmokeHair => in_smoke::hair(stage, seed),
            Self::HairballPanel => hairball::under_a_panel(stage, seed),
            Self::CityPanel => city::under_a_panel(stage, seed),
            Self::Traffic => city::with_traffic(stage, seed),
        }
    }
}
