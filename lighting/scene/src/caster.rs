//! What a triangle does to the light that meets it.

use glam::{Vec2, Vec3, Vec4};

use super::{AlphaMode, Material, Texture};

/// What a triangle does to the light that meets it; [`Geometry::caster`] tells it.
///
/// A method that supports only solid blockers may treat every kind except [`Caster::Absent`] as
/// solid. A method that handles a triangle exactly evaluates its [`Coating`].
///
/// [`Geometry::caster`]: crate::Geometry::caster
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Caster<'a> {
    /// No light passes.
    Solid,
    /// All light passes, as if the triangle were not there: its instance casts
    /// no shadow.
    Absent,
    /// At each point either no light passes or all of it:
    /// [`AlphaMode::Mask`] without transmission.
    Masked(Coating<'a>),
    /// A share of the light passes that may vary over the triangle and between
    /// colour channels: [`AlphaMode::Blend`] or transmission.
    SeeThrough(Coating<'a>),
}

/// The part of a material that decides what passes through a triangle, with
/// what the triangle needs to look it up.
///
/// With the barycentric coordinates (u, v) of the second and the third corner,
/// the opacity is
///
/// α(u, v) = clamp(opacity · vertex α · texture α, 0, 1),
///
/// where vertex α and the texture coordinates are linear in (u, v); the
/// coverage a is α under [`AlphaMode::Blend`], 1 or 0 as α reaches the cutoff or
/// not under [`AlphaMode::Mask`], and 1 under [`AlphaMode::Opaque`]. Of a colour
/// channel the share
///
/// T = 1 − a + a · transmission · C
///
/// passes, where C is the base colour with texture and vertex colour, at most 1, and
/// the transmission is that of the material times the red of its transmission texture.
/// Light goes straight on: nothing is refracted. The angle of incidence has no
/// effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coating<'a> {
    coat: &'a Coat,
    corners: &'a Corners,
}

impl Caster<'_> {
    /// Share of the light that passes at the barycentric coordinates (`u`, `v`)
    /// of the second and third corner, per colour channel, from 0 to 1.
    pub fn transmittance(&self, u: f32, v: f32) -> Vec3 {
        match self {
            Self::Solid => Vec3::ZERO,
            Self::Absent => Vec3::ONE,
            Self::Masked(coating) | Self::SeeThrough(coating) => coating.transmittance(u, v),
        }
    }

    /// The same at a place in f64; see [`Coating::transmittance_at`].
    pub fn transmittance_at(&self, u: f64, v: f64) -> Vec3 {
        match self {
            Self::Solid => Vec3::ZERO,
            Self::Absent => Vec3::ONE,
            Self::Masked(coating) | Self::SeeThrough(coating) => coating.transmittance_at(u, v),
        }
    }

    /// The mean of the transmittance over the triangle, for methods that have
    /// one number per triangle; see [`Coating::mean`].
    pub fn mean(&self) -> Vec3 {
        match self {
            Self::Solid => Vec3::ZERO,
            Self::Absent => Vec3::ONE,
            Self::Masked(coating) | Self::SeeThrough(coating) => coating.mean(),
        }
    }
}

impl<'a> Coating<'a> {
    /// α at a point, from 0 to 1, whatever the mode.
    pub fn opacity(&self, u: f32, v: f32) -> f32 {
        let texture = self.coat.texture.as_ref();
        let texture = texture.map_or(1.0, |t| t.sample_alpha(self.texture_coordinate(u, v)));
        let alpha = self.coat.opacity * self.color(u, v).w * texture;
        alpha.clamp(0.0, 1.0)
    }

    /// The share of a point that the surface covers, from 0 to 1.
    pub fn coverage(&self, u: f32, v: f32) -> f32 {
        self.coat.coverage(|| self.opacity(u, v))
    }

    /// Share of the light that passes at a point, per colour channel, from 0 to
    /// 1.
    pub fn transmittance(&self, u: f32, v: f32) -> Vec3 {
        self.behind(self.coat.coverage(|| self.opacity(u, v)), u, v)
    }

    /// The same at a place in f64. On which side of a mask's border the place lies is decided
    /// in f64, as in [`Coating::along`].
    pub fn transmittance_at(&self, u: f64, v: f64) -> Vec3 {
        let coverage = match self.coat.mode {
            AlphaMode::Mask { cutoff } => {
                let alpha = self.opacity_at(u, v).clamp(0.0, 1.0);
                f32::from(u8::from(alpha >= f64::from(cutoff)))
            }
            _ => self.coverage(u as f32, v as f32),
        };
        self.behind(coverage, u as f32, v as f32)
    }

    /// The share that passes at a point, given the share of it that is covered.
    fn behind(&self, coverage: f32, u: f32, v: f32) -> Vec3 {
        let mut passing = Vec3::splat(1.0 - coverage);
        if self.coat.transmission > 0.0 && coverage > 0.0 {
            let share = self.coat.transmission_texture.as_ref();
            let share = share.map_or(1.0, |t| {
                t.sample(interpolate(self.corners.transmission, u, v)).x
            });
            let texture = self.coat.texture.as_ref();
            let texture = texture.map_or(Vec3::ONE, |t| t.sample(self.texture_coordinate(u, v)));
            let color = self.coat.base_color * self.color(u, v).truncate() * texture;
            let color = color.clamp(Vec3::ZERO, Vec3::ONE);
            passing += coverage * self.coat.transmission * share.min(1.0) * color;
        }
        passing
    }

    /// The transmittance, if it is known to be the same at all points of the triangle without
    /// any lookup: there is no texture, and the corners have the same colour.
    pub fn constant(&self) -> Option<Vec3> {
        let [a, b, c] = self.corners.colors;
        let is_constant = self.coat.texture.is_none()
            && self.coat.transmission_texture.is_none()
            && a == b
            && b == c;
        is_constant.then(|| self.transmittance(0.0, 0.0))
    }

    /// True if no texel of the texture and no corner is opaque enough to cover any of the
    /// triangle, so that all light passes.
    pub fn covers_nothing(&self) -> bool {
        self.coat.is_hole(self.corners)
    }

    /// True if the same share passes in all colour channels, at every point.
    pub fn is_grey(&self) -> bool {
        let is_grey = |color: Vec4| color.x == color.y && color.y == color.z;
        self.coat.is_grey && self.corners.colors.into_iter().all(is_grey)
    }

    /// The mean of the transmittance over the triangle, from its values at the centres of 256
    /// equal parts. A texture with finer detail is sampled at arbitrary points.
    pub fn mean(&self) -> Vec3 {
        if let Some(constant) = self.constant() {
            return constant;
        }
        const SIDE: u32 = 16;
        let mut sum = Vec3::ZERO;
        for row in 0..SIDE {
            for column in 0..SIDE - row {
                let at = |shift: f32| {
                    let place = Vec2::new(column as f32, row as f32) + shift;
                    let place = place / SIDE as f32;
                    self.transmittance(place.x, place.y)
                };
                sum += at(1.0 / 3.0);
                if column + row + 1 < SIDE {
                    sum += at(2.0 / 3.0);
                }
            }
        }
        sum / (SIDE * SIDE) as f32
    }

    /// What the opacity means.
    pub fn mode(&self) -> AlphaMode {
        self.coat.mode
    }

    /// The colour of the material before texture and vertex colours.
    pub fn base_color(&self) -> Vec3 {
        self.coat.base_color
    }

    /// The opacity of the material before texture and vertex colours.
    pub fn base_opacity(&self) -> f32 {
        self.coat.opacity
    }

    /// Share of the covered light that goes through, before texture and base colour.
    pub fn transmission(&self) -> f32 {
        self.coat.transmission
    }

    /// The image whose red multiplies the transmission.
    pub fn transmission_texture(&self) -> Option<&'a Texture> {
        self.coat.transmission_texture.as_ref()
    }

    /// Coordinates of the transmission texture at the three corners; 0 if there is
    /// none.
    pub fn transmission_coordinates(&self) -> [Vec2; 3] {
        self.corners.transmission
    }

    /// The image that colours the surface and holds its opacity;
    /// [`Texture::sampler`] tells how it continues.
    pub fn texture(&self) -> Option<&'a Texture> {
        self.coat.texture.as_ref()
    }

    /// Texture coordinates at the three corners; 0 if there is no texture.
    pub fn texture_coordinates(&self) -> [Vec2; 3] {
        self.corners.coordinates
    }

    /// Vertex colours and opacities at the three corners; 1 if there are none.
    pub fn colors(&self) -> [Vec4; 3] {
        self.corners.colors
    }

    fn texture_coordinate(&self, u: f32, v: f32) -> Vec2 {
        interpolate(self.corners.coordinates, u, v)
    }

    fn color(&self, u: f32, v: f32) -> Vec4 {
        interpolate(self.corners.colors, u, v)
    }
}

/// The value at (`u`, `v`) of what is linear over a triangle.
pub(crate) fn interpolate<T>([a, b, c]: [T; 3], u: f32, v: f32) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    a * (1.0 - u - v) + b * u + c * v
}

/// The part of a [`Material`] that a [`Coating`] needs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coat {
    mode: AlphaMode,
    opacity: f32,
    base_color: Vec3,
    transmission: f32,
    texture: Option<Texture>,
    /// Its red multiplies the transmission.
    transmission_texture: Option<Texture>,
    /// The smallest and the greatest opacity of the texture.
    opacities: [f32; 2],
    /// Whether all colour channels pass alike, but for vertex colours.
    is_grey: bool,
}

/// What a triangle has at its corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corners {
    pub(crate) coordinates: [Vec2; 3],
    pub(crate) transmission: [Vec2; 3],
    pub(crate) colors: [Vec4; 3],
}

fn is_grey(color: &Vec3) -> bool {
    color.x == color.y && color.y == color.z
}

impl Coat {
    /// Without textures; `None` if the material is opaque wherever it is used.
    pub(crate) fn new(material: &Material) -> Option<Self> {
        let is_opaque = material.alpha == AlphaMode::Opaque && material.transmission == 0.0;
        if is_opaque {
            return None;
        }
        Some(Self {
            mode: material.alpha,
            opacity: material.opacity,
            base_color: material.base_color,
            transmission: material.transmission,
            texture: None,
            transmission_texture: None,
            opacities: [1.0; 2],
            is_grey: material.transmission == 0.0 || is_grey(&material.base_color),
        })
    }

    /// The same with the material's texture, for meshes that have coordinates.
    pub(crate) fn with_texture(self, material: &Material) -> Self {
        let texture = material.base_color_texture.clone();
        let alpha = texture.as_ref().and_then(Texture::alpha);
        let opacities = alpha.map_or([1.0; 2], |alpha| {
            let all = alpha.iter().copied();
            [all.clone().fold(1.0, f32::min), all.fold(0.0, f32::max)]
        });
        let is_colourless = texture
            .as_ref()
            .is_none_or(|texture| texture.texels().iter().all(is_grey));
        Self {
            is_grey: self.is_grey && (self.transmission == 0.0 || is_colourless),
            texture,
            opacities,
            ..self
        }
    }

    /// The same with the material's transmission texture.
    pub(crate) fn with_transmission_texture(self, material: &Material) -> Self {
        Self {
            transmission_texture: material
                .transmission_texture
                .clone()
                .filter(|_| self.transmission > 0.0),
            ..self
        }
    }

    /// The share of a point that is covered.
    pub(crate) fn coverage(&self, opacity: impl FnOnce() -> f32) -> f32 {
        match self.mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(u8::from(opacity() >= cutoff)),
            AlphaMode::Blend => opacity(),
        }
    }

    /// True if a triangle with these corners is solid everywhere.
    pub(crate) fn is_solid(&self, corners: &Corners) -> bool {
        let vertices = corners.colors.map(|c| c.w);
        let least = self.opacity * self.opacities[0];
        let least = least * vertices.into_iter().fold(f32::MAX, f32::min);
        self.transmission == 0.0 && self.coverage(|| least.clamp(0.0, 1.0)) == 1.0
    }

    /// True if a triangle with these corners is a hole everywhere.
    fn is_hole(&self, corners: &Corners) -> bool {
        let vertices = corners.colors.map(|c| c.w);
        let most = self.opacity * self.opacities[1];
        let most = most * vertices.into_iter().fold(0.0, f32::max);
        // Interpolated values may be rounded up.
        self.coverage(|| ((1.0 + 1e-6) * most).clamp(0.0, 1.0)) == 0.0
    }

    /// This coat on a triangle with these corners.
    pub(crate) fn on<'a>(&'a self, corners: &'a Corners) -> Caster<'a> {
        let coating = Coating {
            coat: self,
            corners,
        };
        match self.mode {
            AlphaMode::Mask { .. } if self.transmission == 0.0 => Caster::Masked(coating),
            _ => Caster::SeeThrough(coating),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Filter, Geometry, Mesh, Sampler, Scene, Wrap};

    /// A unit square of two triangles with the texture upright on it.
    fn card(material: Material) -> Scene {
        let mut scene = Scene::from(Mesh {
            name: "card".into(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            texture_coordinates: vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(0),
            ..Mesh::default()
        });
        scene.materials.push(material);
        scene
    }

    /// Opaque on the left, nothing on the right, in a pattern of texels.
    fn half(wrap: Wrap, filter: Filter) -> Texture {
        let colours = vec![Vec3::new(1.0, 0.5, 0.0); 2];
        let texture = Texture::new(2, 1, colours).unwrap();
        texture
            .with_alpha(vec![1.0, 0.0])
            .unwrap()
            .with_sampler(Sampler {
                wrap: [wrap; 2],
                filter,
            })
    }

    fn geometry(scene: &Scene) -> Geometry {
        Geometry::new(scene).unwrap()
    }

    #[test]
    fn only_what_is_a_hole_everywhere_covers_nothing() {
        for (opacity, cutoff, nothing) in [
            (0.4, 0.5, true),
            (0.5, 0.5, false),
            (1.0, 0.5, false),
            (0.0, 0.0, false),
        ] {
            let geometry = geometry(&card(Material {
                base_color_texture: Some(half(Wrap::Clamp, Filter::Nearest)),
                opacity,
                alpha: AlphaMode::Mask { cutoff },
                ..Material::default()
            }));
            match geometry.caster(0) {
                Caster::Masked(coating) => assert_eq!(coating.covers_nothing(), nothing),
                other => assert!(cutoff == 0.0 && other == Caster::Solid),
            }
        }
    }

    #[test]
    fn opaque_surfaces_are_solid_whatever_their_texture_says() {
        let scene = card(Material {
            base_color_texture: Some(half(Wrap::Clamp, Filter::Linear)),
            opacity: 0.0,
            ..Material::default()
        });
        let geometry = geometry(&scene);
        assert!(geometry.all_solid());
        for triangle in 0..2 {
            assert_eq!(geometry.caster(triangle), Caster::Solid);
            assert_eq!(
                geometry.caster(triangle).transmittance(0.2, 0.2),
                Vec3::ZERO
            );
        }
    }

    #[test]
    fn a_mask_is_there_where_its_opacity_reaches_the_cutoff() {
        for filter in [Filter::Linear, Filter::Nearest] {
            let scene = card(Material {
                base_color_texture: Some(half(Wrap::Clamp, filter)),
                alpha: AlphaMode::Mask { cutoff: 0.5 },
                ..Material::default()
            });
            let geometry = geometry(&scene);
            assert!(!geometry.all_solid());
            // x is u + v in the first triangle and u in the second.
            for (triangle, u, v, passes) in [
                (0, 0.3, 0.1, 0.0),
                (0, 0.3, 0.3, 1.0),
                (1, 0.45, 0.5, 0.0),
                (1, 0.55, 0.1, 1.0),
            ] {
                let caster = geometry.caster(triangle);
                assert!(matches!(caster, Caster::Masked(_)), "{caster:?}");
                assert_eq!(caster.transmittance(u, v), Vec3::splat(passes));
            }
            // 3/4 of the first triangle are on the right, 1/4 of the second.
            let [first, second] = [0, 1].map(|t| geometry.caster(t).mean().x);
            assert!((first - 0.75).abs() < 0.02 && (second - 0.25).abs() < 0.02);
        }
    }

    #[test]
    fn blending_multiplies_the_three_opacities() {
        let mut scene = card(Material {
            base_color_texture: Some(half(Wrap::Clamp, Filter::Linear)),
            opacity: 0.5,
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
        let alphas = [1.0, 0.5, 0.5, 1.0];
        scene.meshes[0].colors = alphas.map(|a| Vec4::new(1.0, 1.0, 1.0, a)).to_vec();
        let geometry = geometry(&scene);
        let Caster::SeeThrough(coating) = geometry.caster(0) else {
            panic!("{:?}", geometry.caster(0));
        };
        // At x = 0.5: 0.5 of the material, 0.5 of the texture, 0.75 of the vertices.
        assert!((coating.opacity(0.25, 0.25) - 0.1875).abs() < 1e-6);
        assert!((coating.transmittance(0.25, 0.25) - 0.8125).length() < 1e-6);
        assert_eq!(coating.constant(), None);
        assert_eq!(coating.texture_coordinates(), [Vec2::Y, Vec2::ONE, Vec2::X]);
        assert_eq!(
            (coating.base_opacity(), coating.mode()),
            (0.5, AlphaMode::Blend)
        );
    }

    #[test]
    fn glass_lets_its_colour_through() {
        let scene = card(Material {
            base_color: Vec3::new(0.2, 0.9, 1.0),
            transmission: 0.5,
            ..Material::default()
        });
        let geometry = geometry(&scene);
        let Caster::SeeThrough(coating) = geometry.caster(1) else {
            panic!("{:?}", geometry.caster(1));
        };
        let expected = Vec3::new(0.1, 0.45, 0.5);
        assert!((coating.constant().unwrap() - expected).length() < 1e-6);
        assert!((coating.mean() - expected).length() < 1e-6);
        let appearance = geometry.appearance(&scene, 1, 0.2, 0.3);
        assert!(
            (appearance.albedo - expected).length() < 1e-6,
            "the other half"
        );
    }

    #[test]
    fn a_mask_of_glass_passes_light_through_holes_and_glass() {
        let scene = card(Material {
            base_color: Vec3::new(0.2, 1.0, 1.0),
            base_color_texture: Some(half(Wrap::Clamp, Filter::Nearest)),
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            transmission: 1.0,
            ..Material::default()
        });
        let geometry = geometry(&scene);
        let caster = geometry.caster(0);
        assert!(matches!(caster, Caster::SeeThrough(_)));
        assert_eq!(caster.transmittance(0.4, 0.4), Vec3::ONE);
        let glass = caster.transmittance(0.1, 0.1);
        assert!(
            (glass - Vec3::new(0.2, 0.5, 0.0)).length() < 1e-6,
            "{glass}"
        );
    }

    #[test]
    fn nothing_of_a_clear_window_is_seen() {
        let scene = card(Material {
            emitted: Vec3::ONE,
            opacity: 0.0,
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
        let geometry = geometry(&scene);
        assert_eq!(geometry.caster(0).transmittance(0.1, 0.7), Vec3::ONE);
        let appearance = geometry.appearance(&scene, 0, 0.1, 0.7);
        assert_eq!(appearance.albedo, Vec3::ZERO);
        assert_eq!(appearance.emitted, Vec3::ZERO);
    }

    #[test]
    fn modes_that_never_matter_are_solid() {
        let opaque = Texture::new(1, 1, vec![Vec3::ONE]).unwrap();
        for (alpha, opacity) in [
            (AlphaMode::Blend, 1.0),
            (AlphaMode::Mask { cutoff: 0.5 }, 0.5),
            (AlphaMode::Mask { cutoff: 0.0 }, 0.0),
        ] {
            let scene = card(Material {
                base_color_texture: Some(opaque.clone()),
                alpha,
                opacity,
                ..Material::default()
            });
            assert!(geometry(&scene).all_solid(), "{alpha:?} {opacity}");
        }
        // Without texture coordinates the texture, and its alpha, has no effect.
        let mut scene = card(Material {
            base_color_texture: Some(half(Wrap::Clamp, Filter::Linear)),
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
        scene.meshes[0].texture_coordinates.clear();
        assert!(geometry(&scene).all_solid());
    }

    #[test]
    fn what_casts_no_shadow_is_chosen_by_any_of_its_names() {
        let mut scene = card(Material {
            name: "paint".into(),
            ..Material::default()
        });
        scene.instances[0].name = "sign".into();
        for name in ["paint", "sign", "card"] {
            assert_eq!(scene.set_casts_shadow(name, false), 1);
            let hidden = geometry(&scene);
            assert_eq!(hidden.caster(1), Caster::Absent);
            assert_eq!(hidden.caster(1).transmittance(0.0, 0.0), Vec3::ONE);
            assert!(!hidden.all_solid());
            assert_eq!(scene.set_casts_shadow(name, true), 1);
            assert!(geometry(&scene).all_solid());
        }
        assert_eq!(scene.set_casts_shadow("lamp", false), 0);
        assert_eq!(scene.set_casts_shadow("", false), 0);
    }
}
