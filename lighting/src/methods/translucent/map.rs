//! Transmittance maps for all kinds of lights.

use std::fmt::Debug;

use glam::Vec3;
use gpu_backend::{Cpu, Host, Memory};
use transmittance::{Accumulate, CurveMap, Evaluate, Filter, Packed, Receiver};

use super::{Casters, FaceBlockers};
use crate::Emitter;
use crate::scene::raster::{Face, Rays};
use crate::shadow_map::{face_towards, faces, locate};
use crate::visibility::{PointVisibility, SurfaceShadow};

/// The largest number of texels per side of a face.
pub const MAX_RESOLUTION: u32 = 16384;

/// Why a transmittance map could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransmittanceMapError {
    /// The resolution is 0 or above [`MAX_RESOLUTION`].
    #[error("a map of {resolution} texels per side was asked for, expected 1 to {MAX_RESOLUTION}")]
    Resolution {
        /// Texels per side asked for.
        resolution: u32,
    },
    /// There is not enough memory for the curves.
    #[error(transparent)]
    Curves(#[from] transmittance::Error),
}

/// Which share of a light reaches each depth, in every direction from the light: one curve for
/// each texel of the faces that [`shadow_map`](crate::shadow_map) describes, or one for each
/// colour if the casters colour the light.
///
/// A face that sees no caster has a single texel, see [`sides`](TransmittanceMap::sides).
///
/// Depth is the distance along a directional light, and the Euclidean distance from any other
/// light.
///
/// ```
/// use glam::Vec3;
/// use gpu_backend::{Cpu, Host, Memory};
/// use lighting::Emitter;
/// use lighting::scene::{Particle, Particles, Profile, Translucent};
/// use lighting::translucent::{Casters, TransmittanceMap};
/// use transmittance::Stream;
///
/// let puff = Particle { centre: Vec3::Y, radius: 0.5, sigma_t: 2.0 };
/// let puffs = [Translucent::from(Particles::new(vec![puff], Profile::Constant)?)];
/// let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE)?;
/// let casters = Casters::new(&puffs, None);
/// let (clear, cpu) = (Stream::<8>::new(), Cpu::new());
/// let map: TransmittanceMap = TransmittanceMap::build(&cpu, &casters, &sun, 256, &clear)?;
/// assert!((map.transmittance(Vec3::ZERO).x - (-2.0_f32).exp()).abs() < 1e-3); // behind the puff
/// assert!((map.transmittance(Vec3::Y).x - (-1.0_f32).exp()).abs() < 1e-3); // in it
/// assert_eq!(map.transmittance(3.0 * Vec3::Y), Vec3::ONE); // in front of it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TransmittanceMap<M: CurveMemory<T> = Host, T = Packed<8>> {
    pub(super) faces: Vec<Face>,
    /// Texels per side of each face.
    pub(super) sides: Vec<u32>,
    pub(super) resolution: u32,
    /// 1, or 3 for red, green and blue.
    pub(super) channels: usize,
    pub(super) curves: M::Curves,
    pub(super) filter: Filter,
}

/// A memory that can hold curves of the type `T`.
pub trait CurveMemory<T>: Memory {
    /// The curves of all faces.
    type Curves: Debug;
}

/// On the CPU curves of any type: a map for each face, one colour after the other.
impl<T: Debug> CurveMemory<T> for Host {
    type Curves = Vec<CurveMap<T>>;
}

impl<T: Evaluate + Debug + Send> TransmittanceMap<Host, T> {
    /// The map of `emitter` with `resolution` texels per side of each face that sees a caster.
    /// Each curve starts as a copy of `clear` and is stored as a `T`. The result does not depend
    /// on threads.
    ///
    /// Without casters the map is valid, and clear everywhere.
    ///
    /// # Errors
    /// [`TransmittanceMapError::Resolution`] unless the resolution is from 1 to
    /// [`MAX_RESOLUTION`]; [`TransmittanceMapError::Curves`] if there is not enough memory.
    pub fn build<A>(
        cpu: &Cpu,
        casters: &Casters<'_>,
        emitter: &Emitter,
        resolution: u32,
        clear: &A,
    ) -> Result<Self, TransmittanceMapError>
    where
        A: Accumulate + Clone + Sync,
        A::Curve: Into<T>,
    {
        let side = |face: &Face| match casters.needed(face, resolution) {
            0.0 => 1,
            _ => resolution,
        };
        Self::with_sides(cpu, casters, emitter, (resolution, side), clear)
    }

    /// [`TransmittanceMap::build`] with no more texels than [show anything](Casters::side), and
    /// up to `resolution` per side of each face.
    ///
    /// # Errors
    /// Those of [`TransmittanceMap::build`].
    pub fn build_as_needed<A>(
        cpu: &Cpu,
        casters: &Casters<'_>,
        emitter: &Emitter,
        resolution: u32,
        clear: &A,
    ) -> Result<Self, TransmittanceMapError>
    where
        A: Accumulate + Clone + Sync,
        A::Curve: Into<T>,
    {
        let side = |face: &Face| casters.side(face, resolution);
        Self::with_sides(cpu, casters, emitter, (resolution, side), clear)
    }

    /// The map with so many texels per side of each face, of at most a `resolution`.
    pub(super) fn with_sides<A>(
        cpu: &Cpu,
        casters: &Casters<'_>,
        emitter: &Emitter,
        (resolution, side): (u32, impl Fn(&Face) -> u32),
        clear: &A,
    ) -> Result<Self, TransmittanceMapError>
    where
        A: Accumulate + Clone + Sync,
        A::Curve: Into<T>,
    {
        check(resolution)?;
        let mut map = Self {
            faces: casters.planes(emitter),
            sides: Vec::new(),
            resolution,
            channels: casters.channels(),
            curves: Vec::new(),
            filter: Filter::Bilinear,
        };
        let mut colours: Vec<Vec<_>> = (1..map.channels).map(|_| Vec::new()).collect();
        for face in &map.faces {
            let side = side(face);
            let mut blockers = FaceBlockers::new(cpu, casters, face, side);
            let extent = [side as usize; 2];
            map.curves
                .push(CurveMap::build(cpu, extent, clear, &blockers)?);
            for (channel, curves) in (1..).zip(&mut colours) {
                blockers = blockers.of_channel(channel);
                curves.push(CurveMap::build(cpu, extent, clear, &blockers)?);
            }
            map.sides.push(side);
        }
        map.curves.extend(colours.into_iter().flatten());
        Ok(map)
    }
}

impl<M: CurveMemory<T>, T> TransmittanceMap<M, T> {
    /// The same map with another filter. A new map has a bilinear filter.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// One face, or six in the order +X −X +Y −Y +Z −Z; none without casters.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The number of texels per side that was asked for.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Texels per side of each face, in the order of the [faces](TransmittanceMap::faces).
    pub fn sides(&self) -> &[u32] {
        &self.sides
    }

    /// Number of colour channels that have curves of their own: 1 or 3.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The curves of all faces: those of red, followed by those of green and of blue if these
    /// have curves of their own.
    pub fn curves(&self) -> &M::Curves {
        &self.curves
    }

    /// The approximate width of a texel at a point that the light sees, m; 0 without casters.
    pub fn texel_size(&self, point: Vec3) -> f32 {
        if self.faces.is_empty() {
            return 0.0;
        }
        let (index, _) = face_towards(&self.faces, point);
        let (face, half) = (&self.faces[index], 0.5 * self.sides[index] as f32);
        match face.rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => half_width.max(half_height) / half,
            Rays::Central { tan } => tan * point.distance(face.origin) / half,
        }
    }

    /// The filter between the centres of texels.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Memory used by curves of fixed size, bytes.
    pub fn bytes(&self) -> u64 {
        let texels = self.sides.iter().map(|side| u64::from(*side).pow(2));
        self.channels as u64 * texels.sum::<u64>() * size_of::<T>() as u64
    }
}

impl<T: Evaluate + Debug> TransmittanceMap<Host, T> {
    /// The share of the light that reaches `point`, from 0 to 1, per colour. Points outside of
    /// the picture are lit: the picture contains all casters, and a spotlight does not light
    /// such points anyway.
    ///
    /// A filtered map blurs shadows by a texel, also across the borders of surfaces: a surface
    /// that is an opaque caster in the map would shadow itself.
    pub fn transmittance(&self, point: Vec3) -> Vec3 {
        if self.faces.is_empty() {
            return Vec3::ONE;
        }
        let Some(place) = locate(&self.faces, 1, point) else {
            return Vec3::ONE;
        };
        let side = self.sides[place.face] as f32;
        let receiver = Receiver {
            position: place.texel.map(|share| side * share),
            depth: place.depth,
        };
        let of_channel = |channel: usize| {
            let curves = &self.curves[channel * self.faces.len() + place.face];
            curves.transmittance(receiver, self.filter)[0]
        };
        match self.channels {
            1 => Vec3::splat(of_channel(0)),
            _ => Vec3::new(of_channel(0), of_channel(1), of_channel(2)),
        }
    }
}

impl<T: Evaluate + Debug + Sync> PointVisibility for TransmittanceMap<Host, T> {
    type Share = Vec3;

    fn visibility(&self, point: Vec3) -> Vec3 {
        self.transmittance(point)
    }
}

/// This is for maps without opaque casters, because a surface in the map would shadow itself.
impl<T: Evaluate + Debug + Sync> SurfaceShadow for TransmittanceMap<Host, T> {
    fn visibility(&self, point: Vec3, _: Vec3) -> Vec3 {
        self.transmittance(point)
    }
}

impl<'a> Casters<'a> {
    /// The picture planes of a light, each with the blockers that its rays meet, which are
    /// sorted when their turn comes; none if there are no casters.
    ///
    /// # Errors
    /// [`TransmittanceMapError::Resolution`] unless the resolution is from 1 to
    /// [`MAX_RESOLUTION`].
    pub fn faces<'c>(
        &self,
        cpu: &'c Cpu,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<impl Iterator<Item = (Face, FaceBlockers<'a>)> + use<'a, 'c>, TransmittanceMapError>
    {
        check(resolution)?;
        let casters = *self;
        let with_blockers = move |face: Face| {
            let blockers = FaceBlockers::new(cpu, &casters, &face, resolution);
            (face, blockers)
        };
        Ok(self.planes(emitter).into_iter().map(with_blockers))
    }

    /// The picture planes of a light; none if there are no casters.
    pub(super) fn planes(&self, emitter: &Emitter) -> Vec<Face> {
        let planes = self.bounds().map(|bounds| faces(bounds, emitter));
        planes.unwrap_or_default()
    }
}

pub(super) fn check(resolution: u32) -> Result<(), TransmittanceMapError> {
    if (1..=MAX_RESOLUTION).contains(&resolution) {
        return Ok(());
    }
    Err(TransmittanceMapError::Resolution { resolution })
}
