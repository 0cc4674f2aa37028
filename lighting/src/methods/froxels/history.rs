//! Sampling places that change from frame to frame, and the blend of earlier frames.

use gpu_backend::{Backend, Error, Memory};

use super::{FroxelError, FroxelGrid, FroxelSteps, FroxelVolume};

/// The index in Halton's sequence of the point for the first frame. It is an odd multiple of
/// 16, chosen so that the mean of the first 16 points is the middle, to 0.005 in each
/// direction.
const FIRST_POINT: u32 = 2192;

/// The place in each froxel at which light is sampled: across, down and along, each from 0 to
/// 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jitter(pub(super) [f32; 3]);

impl Jitter {
    /// The middle of each froxel.
    pub const MIDDLE: Self = Self([0.5; 3]);

    /// The place for a frame: a point of Halton's sequence with the bases 3, 5 and 2, whose
    /// points are spread evenly over any number of successive frames. Along the ray, which
    /// matters most, any 16 successive points are in 16 equal parts, and the first 16 near the
    /// middles of these.
    pub fn of_frame(frame: u32) -> Self {
        let index = frame.wrapping_add(FIRST_POINT);
        Self([3, 5, 2].map(|base| radical_inverse(index, base)))
    }

    /// Across, down and along.
    pub fn place(self) -> [f32; 3] {
        self.0
    }
}

/// The radical inverse: the digits of a number in reverse, after the point.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    // Rounding to f32 must not make it 1.
    (value as f32).min(1.0 - f32::EPSILON)
}

/// The froxels of successive frames, each sampled at another place and blended with the frames
/// before, which is the temporal filter of engines. The camera may move between frames.
///
/// The first frames after the start, and after a point has come into view, are blended to their
/// mean: frame n has the weight `max(1 − share, 1/n)`. From then on the past fades
/// exponentially. Lights that move or change leave a trail of about `1 / (1 − share)` frames.
/// Light that was scattered towards the eye of an earlier frame counts as scattered towards the
/// eye of this one.
///
/// ```
/// # use glam::Vec3;
/// # use gpu_backend::{Backend, Cpu};
/// # use lighting::froxels::{FroxelAirlight, FroxelGrid, FroxelHistory, FroxelLight, FroxelSteps, InjectFroxels};
/// # use lighting::scene::{Camera, Emission, Medium, PhaseFunction};
/// # use lighting::visibility::Unshadowed;
/// # use lighting::{Emitter, Interval, Ray};
/// let cpu = Cpu::new();
/// let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
/// let lamp = Emitter::point(Vec3::new(0.0, 1.0, -4.0), Vec3::ONE, f32::INFINITY, Emission::Isotropic)?;
/// let mut history = FroxelHistory::new(0.95)?;
/// for frame in 0..4 {
///     let eye = Vec3::X * 0.1 * frame as f32;
///     let camera = Camera::look_at(eye, Vec3::new(0.0, 0.0, -4.0), 1.0)?;
///     let grid = FroxelGrid::new(&camera, [16, 9], 1, 32, Interval::new(0.0, 10.0))?;
///     let mut froxels = history.begin(&cpu, grid)?;
///     let light = FroxelLight { emitter: &lamp, medium: &fog, extinction: true };
///     cpu.inject(&light, &Unshadowed, &mut froxels)?;
///     let froxels = history.finish(&cpu, froxels)?;
///
///     let mut airlight = FroxelAirlight::new(&cpu, grid)?;
///     cpu.integrate(&fog, froxels, &mut airlight)?;
///     let direction = camera.direction(8.0, 4.5, 16, 9);
///     let rays = cpu.upload(&[Ray::new(eye, direction, 8.0).expect("a sound ray")])?;
///     let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
///     cpu.look_up(&airlight, &rays, &mut radiance)?;
///     assert!(radiance[0][0] > 0.0);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FroxelHistory<M: Memory> {
    share: f32,
    frames: u32,
    last: Option<FroxelVolume<M>>,
    /// Memory that the next frame can use.
    spare: Option<FroxelVolume<M>>,
}

impl<M: Memory> FroxelHistory<M> {
    /// A history without frames. Earlier frames will have up to this share of the result;
    /// engines use 0.9 to 0.95.
    ///
    /// # Errors
    /// [`FroxelError::History`] unless the share is at least 0 and below 1.
    pub fn new(share: f32) -> Result<Self, FroxelError> {
        if !(0.0..1.0).contains(&share) {
            return Err(FroxelError::History { share });
        }
        Ok(Self {
            share,
            frames: 0,
            last: None,
            spare: None,
        })
    }

    /// Number of frames so far.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The blended froxels of all frames so far; `None` before the first.
    pub fn last(&self) -> Option<&FroxelVolume<M>> {
        self.last.as_ref()
    }

    /// Dark froxels for the next frame, which are sampled at its place.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    pub fn begin<B>(&mut self, backend: &B, grid: FroxelGrid) -> Result<FroxelVolume<M>, Error>
    where
        B: Backend<Memory = M>,
    {
        let jitter = Jitter::of_frame(self.frames);
        match self.spare.take() {
            Some(spare) => spare.again(backend, grid, jitter),
            None => FroxelVolume::new(backend, grid, jitter),
        }
    }

    /// Blends a frame, into which all lights have been injected, with those before, and keeps
    /// the result for the next frame.
    ///
    /// # Errors
    /// Those of the backend; the frame is lost then.
    pub fn finish<B>(
        &mut self,
        backend: &B,
        mut now: FroxelVolume<M>,
    ) -> Result<&mut FroxelVolume<M>, Error>
    where
        B: FroxelSteps + Backend<Memory = M>,
    {
        self.blend(backend, &mut now)?;
        self.frames = self.frames.wrapping_add(1);
        self.spare = self.last.take();
        Ok(self.last.insert(now))
    }

    /// Blends a frame with those before, which stay as they are.
    pub(super) fn blend<B>(&self, backend: &B, now: &mut FroxelVolume<M>) -> Result<(), Error>
    where
        B: FroxelSteps + Backend<Memory = M>,
    {
        match &self.last {
            Some(before) => backend.blend(before, self.share, now),
            None => Ok(()),
        }
    }
}
