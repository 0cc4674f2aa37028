//! Cookies that are looked up by the length of a step.

use glam::{DVec2, Vec3};
use gpu_backend::{Backend, Error, Host, Memory};

use crate::scene::{SceneError, Texture};

/// The largest number of levels: that of a side of 2³¹ texels.
#[cfg(feature = "wgpu")]
pub(super) const MOST_LEVELS: usize = 32;

/// The largest standard deviation in texels at which an image is blurred; for wider blurs a
/// coarser level suffices.
const BLUR_TEXELS: f64 = 4.0;

/// A cookie with all of its mip levels, down to a single texel. Each texel is the mean of the
/// texels that it [covers](Texture::halved) on the level before.
#[derive(Debug)]
pub struct MipCookie<M: Memory> {
    levels: Vec<Level>,
    /// Red, green and blue of each texel, row by row, level by level.
    texels: M::Buffer<f32>,
}

/// A level, with the index of its first texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) first: u32,
}

impl<M: Memory> MipCookie<M> {
    /// Width and height of the finest level.
    pub fn size(&self) -> [u32; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        let texels = self.levels.iter();
        let texels = texels.map(|level| u64::from(level.width) * u64::from(level.height));
        12 * texels.sum::<u64>()
    }

    #[cfg(feature = "wgpu")]
    pub(super) fn all_levels(&self) -> &[Level] {
        &self.levels
    }

    #[cfg(feature = "wgpu")]
    pub(super) fn texels(&self) -> &M::Buffer<f32> {
        &self.texels
    }
}

impl MipCookie<Host> {
    /// All levels of a cookie.
    pub fn new(cookie: &Texture) -> Self {
        let (mut levels, mut texels) = (Vec::new(), Vec::new());
        let mut next = Some(cookie.clone());
        while let Some(level) = next {
            let (width, height) = (level.width(), level.height());
            levels.push(Level {
                width,
                height,
                // A buffer holds no more texels than a u32 counts.
                first: (texels.len() / 3) as u32,
            });
            texels.extend(level.texels().iter().flat_map(|texel| texel.to_array()));
            next = (width > 1 || height > 1).then(|| level.halved());
        }
        Self { levels, texels }
    }

    /// Copies the cookie to another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit there: 16 bytes for each texel of the
    /// finest level.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<MipCookie<B::Memory>, Error> {
        Ok(MipCookie {
            levels: self.levels.clone(),
            texels: backend.upload(&self.texels)?,
        })
    }

    /// The colour at `uv` for an object that is `texels` texels of the finest level long. It is
    /// a blend of the two levels on which the object is about a texel long, with bilinear
    /// lookups in which border texels continue outside. An object shorter than a texel sees the
    /// finest level.
    pub fn sample(&self, uv: DVec2, texels: f64) -> Vec3 {
        // Logarithms of 0 and NaN are level 0.
        let level = texels.log2().max(0.0).min((self.levels.len() - 1) as f64);
        let (finer, share) = (level.floor(), level.fract() as f32);
        let colour = self.bilinear(finer as usize, uv);
        match share > 0.0 {
            true => colour.lerp(self.bilinear(finer as usize + 1, uv), share),
            false => colour,
        }
    }

    fn bilinear(&self, level: usize, uv: DVec2) -> Vec3 {
        let Level {
            width,
            height,
            first,
        } = self.levels[level];
        let at = uv.clamp(DVec2::ZERO, DVec2::ONE) * DVec2::new(width.into(), height.into()) - 0.5;
        let base = at.floor();
        let f = (at - base).as_vec2();
        let near = |place: f64, size: u32| (place.max(0.0) as u32).min(size - 1) as usize;
        let [left, right] = [base.x, base.x + 1.0].map(|x| near(x, width));
        let [top, bottom] = [base.y, base.y + 1.0].map(|y| near(y, height) * width as usize);
        let texel = |row: usize, column: usize| {
            let i = 3 * (first as usize + row + column);
            Vec3::new(self.texels[i], self.texels[i + 1], self.texels[i + 2])
        };
        let above = texel(top, left).lerp(texel(top, right), f.x);
        let below = texel(bottom, left).lerp(texel(bottom, right), f.x);
        above.lerp(below, f.y)
    }
}

/// A blurred image of a light, which is how section 3.3 of the paper imitates light that
/// scatters more than once. `width` is the standard deviation of a Gaussian, as a share of each
/// side.
///
/// Each side is first halved until few of its texels are as wide as the blur. The image
/// continues mirrored at its borders, so that no light is lost: the mean of all texels stays
/// the same, to rounding.
///
/// # Errors
/// [`SceneError::BadValue`] unless the width is from 0, which blurs nothing, to 1.
pub fn blurred(cookie: &Texture, width: f32) -> Result<Texture, SceneError> {
    if !(0.0..=1.0).contains(&width) {
        return Err(SceneError::BadValue {
            owner: "cookie".into(),
            what: "width of a blur",
            value: width.to_string(),
            expected: "0 to 1",
        });
    }
    let width = f64::from(width);
    let mut image = cookie.clone();
    let wide = |side: u32| width * f64::from(side);
    loop {
        let too_wide = [image.width(), image.height()].map(|side| wide(side) > BLUR_TEXELS);
        if too_wide == [false; 2] {
            break;
        }
        image = image.halved_along(too_wide);
    }
    let size = [image.width(), image.height()].map(|side| side as usize);
    let texels: Vec<_> = image.texels().iter().map(|t| t.as_dvec3()).collect();
    let rows = along(&texels, size, &kernel(wide(image.width())));
    // After one transposition columns are rows, and after another they are columns again.
    let columns = along(&rows, [size[1], size[0]], &kernel(wide(image.height())));
    let texels = columns.iter().map(|texel| texel.as_vec3());
    Texture::new(image.width(), image.height(), texels.collect())
}

/// Weights of the texels on one side of a texel, the first of which is its own.
fn kernel(deviation: f64) -> Vec<f64> {
    let reach = (3.0 * deviation).ceil() as u32;
    let weight = |i: u32| match i {
        0 => 1.0,
        _ => (-0.5 * (f64::from(i) / deviation).powi(2)).exp(),
    };
    let weights: Vec<f64> = (0..=reach).map(weight).collect();
    let sum = 2.0 * weights.iter().sum::<f64>() - weights[0];
    weights.iter().map(|weight| weight / sum).collect()
}

/// Blurs an image with so many columns and rows along its rows, and transposes it.
fn along(texels: &[glam::DVec3], [columns, rows]: [usize; 2], weights: &[f64]) -> Vec<glam::DVec3> {
    let mirrored = |at: isize| {
        let folded = at.rem_euclid(2 * columns as isize) as usize;
        folded.min(2 * columns - 1 - folded)
    };
    let mut turned = Vec::with_capacity(texels.len());
    for column in 0..columns as isize {
        for row in 0..rows {
            let texel = |at: isize| texels[row * columns + mirrored(at)];
            let own = weights[0] * texel(column);
            let others = (1..).zip(&weights[1..]);
            turned.push(others.fold(own, |sum, (i, weight)| {
                sum + *weight * (texel(column - i) + texel(column + i))
            }));
        }
    }
    turned
}
