//! Points that represent an area light.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section
//! 3.1.1, which samples area lights as virtual point lights and leaves open where.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DVec2, Vec2, Vec2Swizzles, Vec3};

use crate::emitter::LEAST_POWER;
use crate::light::spiral;
use crate::{AreaLight, AreaShape, Emission, Emitter, Light, SceneError, Texture};

/// The places of the points that represent an area light; they are the same in every run.
///
/// Except for the lattice, they are points of a unit square. A rectangle takes them as
/// coordinates along its edges, and an ellipse as the square of the radius and the angle, which
/// preserves ratios of areas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pattern {
    /// The points of [`Light::emitters`]: the golden-ratio lattice, and Vogel's
    /// spiral on an ellipse.
    #[default]
    Lattice,
    /// Halton's points with the bases 2 and 3, from the second on. The first n of more points
    /// are the same as for n points.
    Halton,
    /// One random point in each of n cells of equal area, which are in about √n rows.
    Jittered {
        /// The seed of the random points.
        seed: u32,
    },
    /// The centres of the same cells.
    Regular,
    /// The lattice, with a higher density where the texture is brighter: nine tenths of the
    /// density follow the luminance and one tenth the area, in the cells of a grid of 64 × 64.
    /// Without a texture, this is the lattice of the unit square.
    Importance,
}

/// An area light, and the emitters that represent it.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaEmitters {
    /// The light.
    pub light: AreaLight,
    /// The indices of its emitters.
    pub emitters: Range<usize>,
}

impl AreaEmitters {
    /// Finds the area lights among `lights`. Emitter i belongs to the light `owners[i]`, and
    /// emitters of the same light are consecutive. Lights without an emitter are left out.
    pub fn find(lights: &[Light], owners: &[usize]) -> Vec<Self> {
        let mut found = Vec::new();
        let mut start = 0;
        for group in owners.chunk_by(|a, b| a == b) {
            let end = start + group.len();
            if let Some(Light::Area(light)) = lights.get(group[0]) {
                found.push(Self {
                    light: light.clone(),
                    emitters: start..end,
                });
            }
            start = end;
        }
        found
    }
}

/// Cells along each side of the density of [`Pattern::Importance`].
const CELLS: u32 = 64;

/// The uniform share of this density, so that places that look dark are not missed.
const EVEN: f64 = 0.1;

impl AreaLight {
    /// Represents the light by `count` points with a cosine emission; at least 1 and at most
    /// 65536 of them.
    ///
    /// With p the density of the points relative to a uniform one, each point has the share
    /// 1/(n p) of radiance × area, times the mean of the texture over a square around it whose
    /// area is 1/(n p) of the rectangle's. All are scaled so that their sum is the total
    /// emission of the light in each colour. If a colour is dark at every point, none of them
    /// emits it. Less than 1e-20 W/sr counts as 0. The points are in front of the light by 1e-3
    /// of its shorter edge.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if a number is out of its domain.
    pub fn virtual_lights(&self, pattern: Pattern, count: u32) -> Result<Vec<Emitter>, SceneError> {
        self.virtual_lights_placed_by(self, pattern, count)
    }

    /// The same light as points at the places that `placed_by` has for its own points. If only
    /// the textures of the two lights differ, as in two frames of a video, the points change
    /// their intensity and stay in place, even those of [`Pattern::Importance`], so that
    /// whatever was made for their places can be used again.
    ///
    /// # Errors
    /// Those of [`AreaLight::virtual_lights`].
    pub fn virtual_lights_placed_by(
        &self,
        placed_by: &Self,
        pattern: Pattern,
        count: u32,
    ) -> Result<Vec<Emitter>, SceneError> {
        let count = count.clamp(1, 65536);
        let [u, v] = self.edges;
        // The square of a small area underflows in single precision.
        let normal = u.as_dvec3().cross(v.as_dvec3());
        let area = normal.length() as f32;
        if !(self.corner.is_finite() && area.is_finite() && area > 0.0) {
            return Err(SceneError::bad_value(
                "area light",
                "rectangle",
                format!("{} with edges {u} and {v}", self.corner),
                "finite coordinates and two edges that span an area",
            ));
        }
        let places = placed_by.places(pattern, count);
        let normal = normal.normalize().as_vec3();
        let area = match self.shape {
            AreaShape::Rectangle => area,
            AreaShape::Disk => 0.25 * std::f32::consts::PI * area,
        };
        let shares = self.shares(&places);
        let lift = 1e-3 * u.length().min(v.length()) * normal;
        places
            .into_iter()
            .zip(shares)
            .map(|((place, _), share)| {
                let intensity = self.radiance * share * area;
                let is_dark = intensity.abs().cmplt(Vec3::splat(LEAST_POWER));
                Emitter::point(
                    self.corner + place.x * u + place.y * v + lift,
                    Vec3::select(is_dark, Vec3::ZERO, intensity),
                    f32::INFINITY,
                    Emission::Cosine { normal },
                )
            })
            .collect()
    }

    /// Texture coordinates of the points, with the density at each.
    fn places(&self, pattern: Pattern, count: u32) -> Vec<(Vec2, f32)> {
        let even = |points: Vec<DVec2>| -> Vec<_> {
            let place = |point: &DVec2| (self.on_the_light(*point), 1.0);
            points.iter().map(place).collect()
        };
        match (pattern, self.shape, &self.texture) {
            (Pattern::Lattice, AreaShape::Disk, _) => {
                spiral(count).map(|p| (on_the_disk(p), 1.0)).collect()
            }
            (Pattern::Lattice, AreaShape::Rectangle, _)
                if self.edges[0].length() < self.edges[1].length() =>
            {
                lattice(count).map(|p| (p.as_vec2().yx(), 1.0)).collect()
            }
            (Pattern::Lattice, ..) | (Pattern::Importance, _, None) => {
                even(lattice(count).collect())
            }
            (Pattern::Halton, ..) => even(halton(count).collect()),
            (Pattern::Jittered { seed }, ..) => even(cells(count, Some(seed))),
            (Pattern::Regular, ..) => even(cells(count, None)),
            (Pattern::Importance, _, Some(texture)) => {
                let density =
                    Density::new(|cell| luminance(texture.clamp(self.on_the_light(cell))));
                lattice(count)
                    .map(|point| {
                        let (point, density) = density.place(point);
                        (self.on_the_light(point), density as f32)
                    })
                    .collect()
            }
        }
    }

    /// Texture coordinates of a point of the unit square; see [`Pattern`].
    pub(crate) fn on_the_light(&self, point: DVec2) -> Vec2 {
        match self.shape {
            AreaShape::Rectangle => point.as_vec2(),
            AreaShape::Disk => on_the_disk(point.x.sqrt() * DVec2::from_angle(TAU * point.y)),
        }
    }

    /// The share of each place in the light of a white light of this shape.
    fn shares(&self, places: &[(Vec2, f32)]) -> Vec<Vec3> {
        let count = places.len() as f32;
        let Some(texture) = &self.texture else {
            return vec![Vec3::splat(1.0 / count); places.len()];
        };
        let [width, height] = self.edges.map(|edge| edge.as_dvec3().length());
        let aspect = (height / width) as f32;
        let means: Vec<Vec3> = places
            .iter()
            .map(|(place, density)| {
                let size = (Vec2::new(aspect, 1.0 / aspect) / (count * density)).map(f32::sqrt);
                mean_texture(texture, *place, size) / *density
            })
            .collect();
        let total = match self.shape {
            // This is exactly the mean of the bilinear interpolation.
            AreaShape::Rectangle => texture.mean(),
            AreaShape::Disk => {
                const POINTS: u32 = 4096;
                let points = spiral(POINTS).map(on_the_disk);
                points.map(|p| texture.clamp(p)).sum::<Vec3>() / POINTS as f32
            }
        };
        let sum: Vec3 = means.iter().sum();
        // A channel that is dark at all points is 0 at each of them. The quotient of the sums
        // might overflow where little of the light is sampled.
        let share = |mean| Vec3::select(sum.cmpgt(Vec3::ZERO), mean / sum, Vec3::ZERO);
        means.into_iter().map(|mean| share(mean) * total).collect()
    }
}

/// The golden-ratio lattice of `count` points in [0, 1)².
fn lattice(count: u32) -> impl Iterator<Item = DVec2> {
    let step = 0.5 * (5_f64.sqrt() - 1.0);
    (0..count).map(move |i| {
        let i = f64::from(i);
        DVec2::new((i + 0.5) / f64::from(count), (0.5 + i * step).fract())
    })
}

/// Points 1 to `count` of Halton's sequence of the bases 2 and 3.
fn halton(count: u32) -> impl Iterator<Item = DVec2> {
    (1..=count).map(|i| DVec2::new(radical_inverse(i, 2), radical_inverse(i, 3)))
}

/// The radical inverse: the digits of a number in reverse, after the point.
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0 / f64::from(base));
    while number > 0 {
        value += f64::from(number % base) * digit;
        number /= base;
        digit /= f64::from(base);
    }
    value
}

/// One point in each of `count` cells of equal area, in rows whose height is proportional to
/// their number of cells; without a seed, the centre of the cell.
fn cells(count: u32, seed: Option<u32>) -> Vec<DVec2> {
    let rows = (f64::from(count).sqrt().round() as u32).max(1);
    let before = |row: u32| (u64::from(row) * u64::from(count) / u64::from(rows)) as u32;
    let mut points = Vec::with_capacity(count as usize);
    for row in 0..rows {
        let (first, end) = (before(row), before(row + 1));
        for i in first..end {
            let [x, y] = match seed {
                Some(seed) => [2 * i, 2 * i + 1].map(|number| random(number, seed)),
                None => [0.5; 2],
            };
            points.push(DVec2::new(
                (f64::from(i - first) + x) / f64::from(end - first),
                (f64::from(first) + y * f64::from(end - first)) / f64::from(count),
            ));
        }
    }
    points
}

/// A pseudo-random number in [0, 1): the finaliser of MurmurHash3.
fn random(number: u32, seed: u32) -> f64 {
    let mut h = number ^ seed.wrapping_mul(0x9E37_79B9);
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    f64::from(h ^ (h >> 16)) / 4_294_967_296.0
}

/// A density over the unit square, constant in each of [`CELLS`]² cells.
struct Density {
    /// The cumulative share of the rows, up to the end of each.
    rows: Vec<f64>,
    /// The cumulative share of the cells in each row.
    cells: Vec<Vec<f64>>,
}

impl Density {
    /// A density proportional to `weight` at the centre of each cell, plus a small uniform
    /// part.
    fn new(weight: impl Fn(DVec2) -> f32) -> Self {
        let n = CELLS;
        let weights: Vec<Vec<f64>> = (0..n)
            .map(|row| {
                let centre = |column: u32| DVec2::new(column.into(), row.into()) + 0.5;
                let cell = |column| f64::from(weight(centre(column) / f64::from(n)).max(0.0));
                (0..n).map(cell).collect()
            })
            .collect();
        let mean = weights.iter().flatten().sum::<f64>() / f64::from(n * n);
        let part = |weight: f64| {
            if mean > 0.0 {
                EVEN + (1.0 - EVEN) * weight / mean
            } else {
                1.0
            }
        };
        let parts: Vec<Vec<f64>> = (weights.into_iter())
            .map(|row| row.into_iter().map(part).collect())
            .collect();
        let rows: Vec<f64> = parts.iter().map(|row| row.iter().sum()).collect();
        Self {
            rows: sums(&rows),
            cells: parts.iter().map(|row| sums(row)).collect(),
        }
    }

    /// Moves a uniformly distributed point to the density's distribution; returns it with the
    /// density there.
    fn place(&self, point: DVec2) -> (DVec2, f64) {
        let n = f64::from(CELLS);
        let (row, y, high) = find(&self.rows, point.y);
        let (column, x, wide) = find(&self.cells[row], point.x);
        let place = DVec2::new(column as f64 + x, row as f64 + y) / n;
        (place, high * wide * n * n)
    }
}

/// Cumulative sums, as shares of the total.
fn sums(parts: &[f64]) -> Vec<f64> {
    let whole: f64 = parts.iter().sum();
    let mut sum = 0.0;
    let shares = parts.iter().map(|part| {
        sum += part;
        sum / whole
    });
    shares.collect()
}

/// The part in which a share of the total lies, the position within it, and its size.
fn find(sums: &[f64], share: f64) -> (usize, f64, f64) {
    let index = sums
        .partition_point(|sum| *sum <= share)
        .min(sums.len() - 1);
    let before = index.checked_sub(1).map_or(0.0, |last| sums[last]);
    let size = sums[index] - before;
    (index, ((share - before) / size).clamp(0.0, 1.0), size)
}

/// Luminance with the weights of Rec. 709.
fn luminance(colour: Vec3) -> f32 {
    colour.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// From the unit disk to the square of texture coordinates around it.
fn on_the_disk(point: DVec2) -> Vec2 {
    (0.5 + 0.5 * point).as_vec2()
}

/// The mean of the texture over a rectangle around `centre`, from 8 × 8
/// bilinear lookups.
fn mean_texture(texture: &Texture, centre: Vec2, size: Vec2) -> Vec3 {
    const SIDE: u32 = 8;
    let mut sum = Vec3::ZERO;
    for y in 0..SIDE {
        for x in 0..SIDE {
            let offset = (Vec2::new(x as f32, y as f32) + 0.5) / SIDE as f32 - 0.5;
            sum += texture.clamp(centre + offset * size);
        }
    }
    sum / (SIDE * SIDE) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATTERNS: [Pattern; 5] = [
        Pattern::Lattice,
        Pattern::Halton,
        Pattern::Jittered { seed: 7 },
        Pattern::Regular,
        Pattern::Importance,
    ];

    /// A screen whose left half is dark but for a spot.
    fn screen(shape: AreaShape) -> AreaLight {
        let texels = (0..64)
            .map(|i| match (i % 8, i / 8) {
                (1, 2) => Vec3::new(3.0, 0.0, 0.0),
                (x, _) if x < 4 => Vec3::ZERO,
                _ => Vec3::new(0.2, 0.6, 1.0),
            })
            .collect();
        AreaLight {
            shape,
            edges: [2.0 * Vec3::X, Vec3::Y],
            texture: Some(Texture::new(8, 8, texels).unwrap()),
            ..AreaLight::default()
        }
    }

    fn points(light: &AreaLight, pattern: Pattern, count: u32) -> Vec<(Vec2, Vec3)> {
        let emitters = light.virtual_lights(pattern, count).unwrap();
        let point = |emitter: Emitter| {
            let Emitter::Point(point) = emitter else {
                panic!("an area light is near");
            };
            let across = point.position() - light.corner;
            let size = Vec2::new(light.edges[0].length(), light.edges[1].length());
            (across.truncate() / size, point.intensity())
        };
        emitters.into_iter().map(point).collect()
    }

    #[test]
    fn every_pattern_emits_what_the_light_emits_from_points_on_it() {
        for shape in [AreaShape::Rectangle, AreaShape::Disk] {
            let screen = screen(shape);
            let white = AreaLight {
                texture: None,
                ..screen.clone()
            };
            let expected = points(&screen, Pattern::Lattice, 1000);
            let expected: Vec3 = expected.iter().map(|(_, i)| *i).sum();
            for pattern in PATTERNS {
                for count in [1, 2, 5, 16, 100, 257] {
                    let found = points(&white, pattern, count);
                    assert_eq!(found.len(), count as usize);
                    let sum: Vec3 = found.iter().map(|(_, intensity)| *intensity).sum();
                    let area = [2.0, 0.5 * std::f32::consts::PI][shape as usize];
                    assert!((sum / area - 1.0).length() < 1e-4, "{pattern:?} {count}");
                    for (place, _) in found {
                        let out = place - 0.5;
                        let reach = match shape {
                            AreaShape::Rectangle => out.abs().max_element(),
                            AreaShape::Disk => out.length(),
                        };
                        assert!(reach <= 0.5 + 1e-6, "{pattern:?} {count}: {place}");
                    }
                }
                let found = points(&screen, pattern, 257);
                let sum: Vec3 = found.iter().map(|(_, intensity)| *intensity).sum();
                assert!((sum / expected - 1.0).length() < 1e-3, "{pattern:?} {sum}");
            }
        }
    }

    #[test]
    fn even_patterns_have_even_shares_of_any_half_and_importance_looks_at_what_is_bright() {
        let screen = screen(AreaShape::Rectangle);
        for pattern in PATTERNS {
            let found = points(&screen, pattern, 256);
            let left = found.iter().filter(|(place, _)| place.x < 0.5).count();
            let low = found.iter().filter(|(place, _)| place.y < 0.5).count();
            assert!(low.abs_diff(128) <= 24, "{pattern:?}: {low}");
            if pattern == Pattern::Importance {
                // 10 % of half the area, and 0.64 of the 19.0 that are bright.
                assert!((15..=32).contains(&left), "{left}");
                let spot = Vec2::new(1.5, 2.5) / 8.0;
                let at_spot =
                    |(place, _): &&(Vec2, Vec3)| (*place - spot).abs().max_element() < 0.1;
                assert!(found.iter().filter(at_spot).count() >= 6);
            } else {
                assert!(left.abs_diff(128) <= 2, "{pattern:?}: {left}");
            }
        }
    }

    #[test]
    fn patterns_are_the_same_in_every_run_and_halton_goes_on() {
        let light = AreaLight::default();
        for pattern in PATTERNS {
            assert_eq!(points(&light, pattern, 33), points(&light, pattern, 33));
        }
        let other = Pattern::Jittered { seed: 8 };
        assert_ne!(points(&light, PATTERNS[2], 9), points(&light, other, 9));
        let [few, more] = [9, 30].map(|count| points(&light, Pattern::Halton, count));
        for ((few, _), (more, _)) in few.iter().zip(&more) {
            assert_eq!(few, more);
        }
    }

    #[test]
    fn another_texture_in_the_same_places_changes_intensities_alone() {
        for shape in [AreaShape::Rectangle, AreaShape::Disk] {
            let before = screen(shape);
            let texels = (0..64).map(|i| Vec3::splat((i % 8) as f32)).collect();
            let after = AreaLight {
                texture: Some(Texture::new(8, 8, texels).unwrap()),
                ..before.clone()
            };
            for pattern in PATTERNS {
                let old = before.virtual_lights(pattern, 200).unwrap();
                let new = after
                    .virtual_lights_placed_by(&before, pattern, 200)
                    .unwrap();
                for (old, new) in old.iter().zip(&new) {
                    let (Emitter::Point(old), Emitter::Point(new)) = (old, new) else {
                        panic!("an area light is near");
                    };
                    assert_eq!(old.position(), new.position());
                }
                assert_ne!(old, new);
                let sum = |all: &[Emitter]| all.iter().map(Emitter::intensity).sum::<Vec3>();
                let own = sum(&after.virtual_lights(Pattern::Lattice, 1000).unwrap());
                assert!((sum(&new) / own - 1.0).length() < 1e-3, "{pattern:?}");
                let same = before.virtual_lights_placed_by(&before, pattern, 200);
                assert_eq!(same.unwrap(), old);
            }
        }
    }

    #[test]
    fn a_black_screen_has_dark_points() {
        let black = AreaLight {
            texture: Some(Texture::new(1, 1, vec![Vec3::ZERO]).unwrap()),
            ..AreaLight::default()
        };
        for pattern in PATTERNS {
            assert!(
                points(&black, pattern, 5)
                    .iter()
                    .all(|(_, i)| *i == Vec3::ZERO)
            );
        }
    }

    #[test]
    fn small_lights_and_dim_points_emit_what_they_should() {
        // None of the points sees the one texel that is bright.
        let mut texels = vec![Vec3::splat(1e-40); 512 * 512];
        texels[0] = Vec3::splat(1e6);
        let corner = Texture::new(512, 512, texels).unwrap();
        // Points on the right have less than an emitter may have.
        let half = Texture::new(2, 1, vec![Vec3::ONE, Vec3::splat(1e-35)]).unwrap();
        for (texture, edge) in [(&corner, 1.0), (&corner, 1e-12), (&half, 1.0)] {
            let screen = AreaLight {
                edges: [edge * Vec3::X, 2.0 * edge * Vec3::Y],
                radiance: Vec3::splat(1e9),
                texture: Some(texture.clone()),
                ..AreaLight::default()
            };
            let expected = 2.0 * edge * edge * 1e9 * texture.mean();
            for pattern in PATTERNS {
                let found = screen.virtual_lights(pattern, 16).unwrap();
                let sum: Vec3 = found.iter().map(Emitter::intensity).sum();
                assert!((sum / expected - 1.0).length() < 1e-4, "{edge} {pattern:?}");
            }
        }
    }

    #[test]
    fn area_lights_know_their_emitters() {
        let lights = [
            Light::Point(crate::PointLight::default()),
            Light::Area(AreaLight::default()),
            Light::Area(screen(AreaShape::Disk)),
        ];
        let found = AreaEmitters::find(&lights, &[0, 1, 1, 1, 2]);
        let ranges: Vec<_> = found.iter().map(|area| area.emitters.clone()).collect();
        assert_eq!(ranges, [1..4, 4..5]);
        assert_eq!(found[1].light, screen(AreaShape::Disk));
        assert!(AreaEmitters::find(&lights, &[0]).is_empty());
        assert!(AreaEmitters::find(&[], &[3]).is_empty());
    }
}
