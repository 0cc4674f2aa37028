//! Linear RGB images on surfaces and in front of lights.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::SceneError;

/// A linear RGB image, shared cheaply between its users.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    texels: Arc<[Vec3]>,
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
        })
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

    /// The mean of all texels.
    pub fn mean(&self) -> Vec3 {
        let sum = self
            .texels
            .iter()
            .fold(glam::DVec3::ZERO, |sum, t| sum + t.as_dvec3());
        (sum / self.texels.len() as f64).as_vec3()
    }

    /// Bilinear lookup that repeats in both directions; texel centres lie at
    /// `(i + ½) / size`, (0, 0) is the upper left corner.
    pub fn repeat(&self, uv: Vec2) -> Vec3 {
        self.bilinear(uv - uv.floor(), |i, n| i.rem_euclid(n))
    }

    /// Bilinear lookup that holds the border texels outside of [0, 1]².
    pub fn clamp(&self, uv: Vec2) -> Vec3 {
        self.bilinear(uv.clamp(Vec2::ZERO, Vec2::ONE), |i, n| i.clamp(0, n - 1))
    }

    fn bilinear(&self, uv: Vec2, wrap: impl Fn(i64, i64) -> i64) -> Vec3 {
        if !uv.is_finite() {
            return self.texels[0];
        }
        let position = uv * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let base = position.floor();
        let f = position - base;
        let (x, y) = (base.x as i64, base.y as i64);
        let texel = |x, y| {
            let column = wrap(x, i64::from(self.width)) as usize;
            let row = wrap(y, i64::from(self.height)) as usize;
            self.texels[row * self.width as usize + column]
        };
        let top = texel(x, y).lerp(texel(x + 1, y), f.x);
        let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), f.x);
        top.lerp(bottom, f.y)
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
    fn bad_textures_are_refused() {
        assert!(Texture::new(0, 4, vec![]).is_err());
        assert!(Texture::new(2, 2, vec![Vec3::ONE; 3]).is_err());
        assert!(Texture::new(1, 1, vec![Vec3::splat(-1.0)]).is_err());
        assert!(Texture::new(1, 1, vec![Vec3::NAN]).is_err());
    }
}
