//! Linear RGB images for surfaces and for cookies of lights.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::SceneError;

/// A linear RGB image that can have an opacity per texel. Copies share the texels.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    texels: Arc<[Vec3]>,
    alpha: Option<Arc<[f32]>>,
    sampler: Sampler,
}

/// How a [`Texture`] continues outside of [0, 1]² and between its texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Sampler {
    /// Along u and v.
    pub wrap: [Wrap; 2],
    /// Between texel centres.
    pub filter: Filter,
}

/// How a texture continues outside of [0, 1] along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, and every other copy is mirrored.
    Mirror,
    /// The texels of the border continue.
    Clamp,
}

/// The values between the centres of texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Filter {
    /// A bilinear blend of the four nearest texels.
    #[default]
    Linear,
    /// The nearest texel.
    Nearest,
}

impl Texture {
    /// An image of `width` × `height` texels, row by row from the top.
    ///
    /// # Errors
    /// [`SceneError::LengthMismatch`] if the number of texels is not `width` ×
    /// `height`; [`SceneError::BadValue`] if a side is 0 or a texel is negative
    /// or not finite.
    pub fn new(width: u32, height: u32, texels: Vec<Vec3>) -> Result<Self, SceneError> {
        let expected = width as usize * height as usize;
        if expected == 0 {
            return Err(SceneError::bad_value(
                "texture",
                "size",
                format!("{width} x {height}"),
                "at least one texel",
            ));
        }
        if texels.len() != expected {
            return Err(SceneError::LengthMismatch {
                owner: "texture".into(),
                what: "texels",
                actual: texels.len(),
                expected,
            });
        }
        if let Some(texel) = texels
            .iter()
            .find(|t| !t.is_finite() || t.min_element() < 0.0)
        {
            return Err(SceneError::bad_value(
                "texture",
                "a texel",
                texel,
                "finite, not negative",
            ));
        }
        Ok(Self {
            width,
            height,
            texels: texels.into(),
            alpha: None,
            sampler: Sampler::default(),
        })
    }

    /// The same image with an opacity per texel, row by row from the top: 0 is fully
    /// transparent, 1 is opaque.
    ///
    /// # Errors
    /// [`SceneError::LengthMismatch`] if there is not one opacity per texel;
    /// [`SceneError::BadValue`] if one is not from 0 to 1.
    pub fn with_alpha(self, alpha: Vec<f32>) -> Result<Self, SceneError> {
        if alpha.len() != self.texels.len() {
            return Err(SceneError::LengthMismatch {
                owner: "texture".into(),
                what: "the list of opacities",
                actual: alpha.len(),
                expected: self.texels.len(),
            });
        }
        if let Some(value) = alpha.iter().find(|a| !(0.0..=1.0).contains(*a)) {
            return Err(SceneError::bad_value(
                "texture",
                "an opacity",
                value,
                "0 to 1",
            ));
        }
        Ok(Self {
            alpha: Some(alpha.into()),
            ..self
        })
    }

    /// The same image with another sampler for [`Texture::sample`] and
    /// [`Texture::sample_alpha`].
    pub fn with_sampler(self, sampler: Sampler) -> Self {
        Self { sampler, ..self }
    }

    /// Texels per row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All texels, row by row from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// The opacity of all texels, row by row from the top; `None` if the image
    /// is opaque.
    pub fn alpha(&self) -> Option<&[f32]> {
        self.alpha.as_deref()
    }

    /// How the image continues outside of [0, 1]² and between its texels.
    pub fn sampler(&self) -> Sampler {
        self.sampler
    }

    /// The mean of all texels.
    pub fn mean(&self) -> Vec3 {
        let sum = self
            .texels
            .iter()
            .fold(glam::DVec3::ZERO, |sum, t| sum + t.as_dvec3());
        (sum / self.texels.len() as f64).as_vec3()
    }

    /// The next coarser mip level: half as many texels along each side, rounded up,
    /// each the mean of what it covers. It is opaque.
    pub fn halved(&self) -> Self {
        self.halved_along([true, true])
    }

    /// The same as [`halved`](Self::halved) with half as many texels in each row, in each
    /// column, or both.
    pub fn halved_along(&self, [rows, columns]: [bool; 2]) -> Self {
        let texels = |side, is_halved| match is_halved {
            true => halves(side),
            false => (0..side as usize)
                .map(|texel| [Some((texel, 1.0)), None, None])
                .collect(),
        };
        let (columns, rows) = (texels(self.width, rows), texels(self.height, columns));
        let [width, height] = [&columns, &rows].map(|side| side.len() as u32);
        let texels = rows.iter().flat_map(|row| {
            columns.iter().map(move |column| {
                let mut sum = glam::DVec3::ZERO;
                for &(y, along) in row.iter().flatten() {
                    for &(x, across) in column.iter().flatten() {
                        let texel = self.texels[y * self.width as usize + x];
                        sum += along * across * texel.as_dvec3();
                    }
                }
                sum.as_vec3()
            })
        });
        Self {
            width,
            height,
            texels: texels.collect(),
            alpha: None,
            sampler: self.sampler,
        }
    }

    /// The colour at `uv` according to the sampler. The centres of texels are at `(i + ½) /
    /// size`, and (0, 0) is the upper left corner. Coordinates that are not finite give the
    /// first texel.
    pub fn sample(&self, uv: Vec2) -> Vec3 {
        self.blend(uv, self.sampler, |index| self.texels[index])
    }

    /// The opacity at `uv` according to the sampler; 1 if the image is opaque.
    pub fn sample_alpha(&self, uv: Vec2) -> f32 {
        match &self.alpha {
            Some(alpha) => self.blend(uv, self.sampler, |index| alpha[index]),
            None => 1.0,
        }
    }

    /// The opacity of the texel at `column` and `row`, which may lie outside of the image,
    /// according to the sampler; 1 if the image is opaque.
    pub(crate) fn texel_alpha(&self, column: i64, row: i64) -> f32 {
        let [wrap_u, wrap_v] = self.sampler.wrap;
        let (column, row) = (
            wrap_u.index(column, self.width),
            wrap_v.index(row, self.height),
        );
        let alpha = self.alpha.as_ref();
        alpha.map_or(1.0, |alpha| alpha[row * self.width as usize + column])
    }

    /// Bilinear lookup in the image repeated in both directions, whatever the sampler.
    pub fn repeat(&self, uv: Vec2) -> Vec3 {
        self.blend(uv, Sampler::default(), |index| self.texels[index])
    }

    /// Bilinear lookup in which the border texels continue outside of [0, 1]², whatever the
    /// sampler.
    pub fn clamp(&self, uv: Vec2) -> Vec3 {
        let sampler = Sampler {
            wrap: [Wrap::Clamp; 2],
            filter: Filter::Linear,
        };
        self.blend(uv, sampler, |index| self.texels[index])
    }

    fn blend<T>(&self, uv: Vec2, sampler: Sampler, texel: impl Fn(usize) -> T) -> T
    where
        T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
    {
        if !uv.is_finite() {
            return texel(0);
        }
        let [wrap_u, wrap_v] = sampler.wrap;
        let uv = Vec2::new(wrap_u.near(uv.x), wrap_v.near(uv.y));
        let size = Vec2::new(self.width as f32, self.height as f32);
        let at = |x: f32, y: f32| {
            let column = wrap_u.index(x as i64, self.width);
            let row = wrap_v.index(y as i64, self.height);
            texel(row * self.width as usize + column)
        };
        if sampler.filter == Filter::Nearest {
            let texel = (uv * size).floor();
            return at(texel.x, texel.y);
        }
        let position = uv * size - 0.5;
        let base = position.floor();
        let f = position - base;
        let (x, y) = (base.x, base.y);
        let top = at(x, y) * (1.0 - f.x) + at(x + 1.0, y) * f.x;
        let bottom = at(x, y + 1.0) * (1.0 - f.x) + at(x + 1.0, y + 1.0) * f.x;
        top * (1.0 - f.y) + bottom * f.y
    }
}

/// If `size` texels in a row are reduced to half as many, rounded up: for each of these, the
/// texels that it covers, with their shares.
fn halves(size: u32) -> Vec<[Option<(usize, f64)>; 3]> {
    let half = size.div_ceil(2);
    let width = f64::from(size) / f64::from(half);
    (0..half)
        .map(|i| {
            let (start, end) = (f64::from(i) * width, f64::from(i + 1) * width);
            [0.0, 1.0, 2.0].map(|k| {
                let texel = start.floor() + k;
                let share = (end.min(texel + 1.0) - start.max(texel)) / width;
                let is_there = share > 0.0 && texel < f64::from(size);
                is_there.then_some((texel as usize, share))
            })
        })
        .collect()
}

impl Wrap {
    /// An equivalent coordinate close to [0, 1], where an `f32` can tell texels apart.
    fn near(self, coordinate: f32) -> f32 {
        match self {
            Self::Repeat => coordinate - coordinate.floor(),
            Self::Mirror => coordinate - 2.0 * (0.5 * coordinate).floor(),
            Self::Clamp => coordinate.clamp(0.0, 1.0),
        }
    }

    /// The index among `count` texels of the one that appears at `index`.
    fn index(self, index: i64, count: u32) -> usize {
        let count = i64::from(count);
        let index = match self {
            Self::Repeat => index.rem_euclid(count),
            Self::Mirror => {
                let folded = index.rem_euclid(2 * count);
                folded.min(2 * count - 1 - folded)
            }
            Self::Clamp => index.clamp(0, count - 1),
        };
        index as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookups_meet_texel_centres_and_wrap() {
        let texels = (0..6).map(|i| Vec3::splat(i as f32)).collect();
        let texture = Texture::new(3, 2, texels).unwrap();
        let centre = |x: f32, y: f32| Vec2::new((x + 0.5) / 3.0, (y + 0.5) / 2.0);
        assert!((texture.clamp(centre(2.0, 1.0)).x - 5.0).abs() < 1e-5);
        assert!((texture.repeat(centre(-1.0, 0.0)).x - 2.0).abs() < 1e-5);
        assert_eq!(texture.clamp(Vec2::new(9.0, -9.0)).x, 2.0);
        assert!((texture.clamp(centre(0.5, 0.0)).x - 0.5).abs() < 1e-5);
        assert_eq!(texture.mean().x, 2.5);
        assert!(texture.repeat(Vec2::NAN).is_finite());
    }

    #[test]
    fn samplers_continue_an_image_as_they_say() {
        let texels = (0..3).map(|i| Vec3::splat(i as f32)).collect();
        let plain = Texture::new(3, 1, texels).unwrap();
        let at = |wrap, filter, column: f32| {
            let sampler = Sampler {
                wrap: [wrap, Wrap::Clamp],
                filter,
            };
            let texture = plain.clone().with_sampler(sampler);
            assert_eq!(texture.sampler(), sampler);
            texture.sample(Vec2::new((column + 0.5) / 3.0, 0.5)).x
        };
        let columns = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 301.0];
        for (wrap, expected) in [
            (Wrap::Repeat, [1, 2, 0, 1, 2, 0, 1, 2, 0, 1]),
            (Wrap::Mirror, [1, 0, 0, 1, 2, 2, 1, 0, 0, 1]),
            (Wrap::Clamp, [0, 0, 0, 1, 2, 2, 2, 2, 2, 2]),
        ] {
            for (column, expected) in columns.into_iter().zip(expected) {
                for filter in [Filter::Linear, Filter::Nearest] {
                    let found = at(wrap, filter, column);
                    let off = (found - expected as f32).abs();
                    assert!(off < 1e-4, "{wrap:?} {filter:?} {column}: {found}");
                }
            }
        }
        assert_eq!(at(Wrap::Repeat, Filter::Nearest, 0.49), 0.0);
        assert!((at(Wrap::Repeat, Filter::Linear, 0.25) - 0.25).abs() < 1e-5);
        assert!((at(Wrap::Mirror, Filter::Linear, 2.5) - 2.0).abs() < 1e-5);
    }

    #[test]
    fn opacity_is_looked_up_like_colour() {
        let opaque = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
        assert_eq!(opaque.sample_alpha(Vec2::splat(0.3)), 1.0);
        let card = opaque.clone().with_alpha(vec![0.0, 1.0]).unwrap();
        assert_eq!(card.alpha(), Some(&[0.0, 1.0][..]));
        assert_eq!(card.sample_alpha(Vec2::new(0.5, 0.5)), 0.5);
        assert_eq!(card.sample_alpha(Vec2::new(0.25, 0.5)), 0.0);
        assert!(opaque.clone().with_alpha(vec![0.0]).is_err());
        assert!(opaque.clone().with_alpha(vec![0.0, 1.5]).is_err());
        assert!(opaque.with_alpha(vec![f32::NAN, 1.0]).is_err());
    }

    #[test]
    fn half_an_image_has_the_means_of_what_it_covers() {
        let texels = (0..15).map(|i| Vec3::splat((i * i % 7) as f32)).collect();
        let texture = Texture::new(5, 3, texels).unwrap();
        let half = texture.halved();
        assert_eq!((half.width(), half.height()), (3, 2));
        assert!((half.mean() - texture.mean()).length() < 1e-5);
        // All of the first texel and two thirds of the next one, and half a row more.
        let row = |y: f32| (y * y % 7.0 + 2.0 / 3.0 * ((y + 1.0) * (y + 1.0) % 7.0)) * 0.6;
        let expected = (row(0.0) + 0.5 * row(5.0)) / 1.5;
        assert!((half.texels()[0].x - expected).abs() < 1e-5);
        for (along, size) in [
            ([true, false], (3, 3)),
            ([false, true], (5, 2)),
            ([false, false], (5, 3)),
        ] {
            let part = texture.halved_along(along);
            assert_eq!((part.width(), part.height()), size);
            let rest = part.halved_along(along.map(|is_halved| !is_halved));
            let off = rest.texels().iter().zip(half.texels());
            assert!(off.map(|(a, b)| (*a - *b).length()).fold(0.0, f32::max) < 1e-5);
        }
        let mut smallest = texture;
        for _ in 0..4 {
            smallest = smallest.halved();
        }
        assert_eq!((smallest.width(), smallest.height()), (1, 1));
    }

    #[test]
    fn bad_textures_are_refused() {
        assert!(Texture::new(0, 4, vec![]).is_err());
        assert!(Texture::new(2, 2, vec![Vec3::ONE; 3]).is_err());
        assert!(Texture::new(1, 1, vec![Vec3::splat(-1.0)]).is_err());
        assert!(Texture::new(1, 1, vec![Vec3::NAN]).is_err());
    }
}
