//! The light that passes along a line over a triangle.

use glam::{DVec2, Vec2, Vec3};

use super::{AlphaMode, Coating, Filter, Texture};

/// A part of a line over a triangle, from 0 to 1 along it, and the share of the
/// light that passes there, per colour channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// Where the part begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// The transmittance: exact at each point of a mask, elsewhere the mean over the part.
    pub transmittance: Vec3,
}

/// A line that crosses more texels than this is cut into as many equal parts.
const MOST_CELLS: f64 = 65536.0;

/// The largest variation of the transmittance within a part.
const STEP: f32 = 1.0 / 64.0;

/// The largest number of parts for the line over one texel, in addition to those that end at
/// the border of a mask.
const MOST_STEPS: f32 = 64.0;

impl Coating<'_> {
    /// Calls `part` for the parts of the line from `start` to `end`, which are barycentric
    /// coordinates of the second and third corner. Parts are in order, from 0 to 1 without
    /// gaps.
    ///
    /// Between the texel centres of both textures that the line passes, the opacity is a cubic
    /// polynomial in the position on the line. Where it crosses the cutoff of a mask is
    /// computed in f64, so the ends of holes are exact. If the transmittance varies, each part
    /// has its mean, over a part in which it varies by about 1/64, or over a 64th of a texel. A
    /// line that crosses more than 65536 texels is cut into as many equal parts instead, each
    /// with the value at its middle.
    ///
    /// Cost: proportional to the number of texels crossed.
    pub fn along(&self, start: DVec2, end: DVec2, mut part: impl FnMut(Passing)) {
        if let Some(transmittance) = self.constant() {
            part(Passing {
                from: 0.0,
                to: 1.0,
                transmittance,
            });
            return;
        }
        let mut joined: Option<Passing> = None;
        let mut put = |next: Passing| match &mut joined {
            Some(last) if last.transmittance == next.transmittance => last.to = next.to,
            last => {
                if let Some(done) = last.replace(next) {
                    part(done);
                }
            }
        };
        let line = Line::new(self, start, end);
        line.for_each_cell(|from, to, is_one_cell| {
            if !is_one_cell {
                let transmittance = line.transmittance(0.5 * (from + to));
                put(Passing {
                    from,
                    to,
                    transmittance,
                });
                return;
            }
            let mut last = from;
            if let AlphaMode::Mask { cutoff } = self.mode() {
                for at in crossings(line.cubic(from, to), f64::from(cutoff)) {
                    let at = from + at * (to - from);
                    if last < at && at < to {
                        line.smooth(last, at, &mut put);
                        last = at;
                    }
                }
            }
            line.smooth(last, to, &mut put);
        });
        part(joined.expect("a line has parts"));
    }
}

impl Coating<'_> {
    /// The opacity at a point before it is clamped to 1, in f64.
    pub(crate) fn opacity_at(&self, u: f64, v: f64) -> f64 {
        let place = DVec2::new(u, v);
        let line = Line::new(self, place, place);
        line.cubic(0.0, 0.0)[0]
    }
}

/// The line as it crosses the texels of a texture.
#[derive(Clone, Copy, Default)]
struct Track {
    /// Position in the texture at 0, and its change from 0 to 1, in texels to the right and
    /// down. Cells change at integers. 0 without a texture.
    texel: DVec2,
    texels: DVec2,
}

impl Track {
    fn new(texture: Option<&Texture>, coordinates: [Vec2; 3], [start, end]: [DVec2; 2]) -> Self {
        let Some(texture) = texture else {
            return Self::default();
        };
        let size = DVec2::new(texture.width().into(), texture.height().into());
        let shift = match texture.sampler().filter {
            Filter::Linear => 0.5,
            Filter::Nearest => 0.0,
        };
        let [a, b, c] = coordinates.map(|uv| uv.as_dvec2());
        let texel = |at: DVec2| {
            let [p, q, r] = weights(at);
            (p * a + q * b + r * c) * size - shift
        };
        let track = Self {
            texel: texel(start),
            texels: texel(end) - texel(start),
        };
        // Coordinates that are not finite mean the first texel.
        if track.texel.is_finite() && track.texels.is_finite() {
            track
        } else {
            Self::default()
        }
    }
}

/// The weights of the three corners at a point.
fn weights(at: DVec2) -> [f64; 3] {
    [1.0 - at.x - at.y, at.x, at.y]
}

/// The line in coordinates of the textures.
struct Line<'a> {
    coating: &'a Coating<'a>,
    start: DVec2,
    along: DVec2,
    /// The line in the texture of colour and opacity, and in that of the transmission.
    color: Track,
    transmission: Track,
    /// Opacity of the material times that of the vertices, at 0 and at 1.
    vertex: [f64; 2],
}

impl<'a> Line<'a> {
    fn new(coating: &'a Coating<'a>, start: DVec2, end: DVec2) -> Self {
        let ends = [start, end];
        let vertex = |at: DVec2| {
            let [a, b, c] = coating.colors().map(|color| f64::from(color.w));
            let [p, q, r] = weights(at);
            f64::from(coating.base_opacity()) * (p * a + q * b + r * c)
        };
        Self {
            coating,
            start,
            along: end - start,
            color: Track::new(coating.texture(), coating.texture_coordinates(), ends),
            transmission: Track::new(
                coating.transmission_texture(),
                coating.transmission_coordinates(),
                ends,
            ),
            vertex: ends.map(vertex),
        }
    }

    /// Calls `cell(from, to, is_one_cell)` for the parts between changes of texel.
    fn for_each_cell(&self, mut cell: impl FnMut(f64, f64, bool)) {
        let of_track = |track: Track| {
            let (at, way) = (track.texel, track.texels);
            [(at.x, way.x), (at.y, way.y)]
        };
        let axes = [of_track(self.color), of_track(self.transmission)];
        let axes = match self.coating.transmission_texture() {
            None => axes[0].as_slice(),
            Some(_) => axes.as_flattened(),
        };
        let count: f64 = axes.iter().map(|(_, way)| way.abs()).sum();
        // This holds for NaN too.
        if !(count < MOST_CELLS) {
            for i in 0..MOST_CELLS as u32 {
                let at = |i: u32| f64::from(i) / MOST_CELLS;
                cell(at(i), at(i + 1), false);
            }
            return;
        }
        let mut next = [0.0; 4];
        for (next, &(at, way)) in next.iter_mut().zip(axes) {
            *next = if way > 0.0 {
                at.floor() + 1.0
            } else {
                at.ceil() - 1.0
            };
        }
        let mut from = 0.0;
        while from < 1.0 {
            let (mut axis, mut to) = (0, f64::INFINITY);
            for (index, (&(at, way), line)) in axes.iter().zip(next).enumerate() {
                let crossing = (line - at) / way;
                if way != 0.0 && crossing < to {
                    (axis, to) = (index, crossing);
                }
            }
            let to = to.min(1.0);
            next[axis] += axes[axis].1.signum();
            if to > from {
                cell(from, to, true);
                from = to;
            }
        }
    }

    /// The opacity, before it is clamped to 1, between two positions in the same cell: the
    /// coefficients of a polynomial in the position from 0 to 1 between them.
    fn cubic(&self, from: f64, to: f64) -> [f64; 4] {
        let width = to - from;
        let vertex = |at: f64| self.vertex[0] + at * (self.vertex[1] - self.vertex[0]);
        let (w0, w1) = (vertex(from), vertex(to) - vertex(from));
        let [q0, q1, q2] = match self.coating.texture() {
            None => [1.0, 0.0, 0.0],
            Some(texture) => {
                let middle = (self.color.texel + 0.5 * (from + to) * self.color.texels).floor();
                let (column, row) = (middle.x as i64, middle.y as i64);
                // Casts saturate: coordinates may be any number.
                let at = |x: i64, y: i64| {
                    let (column, row) = (column.saturating_add(x), row.saturating_add(y));
                    f64::from(texture.texel_alpha(column, row))
                };
                match texture.sampler().filter {
                    Filter::Nearest => [at(0, 0), 0.0, 0.0],
                    Filter::Linear => {
                        let first = self.color.texel + from * self.color.texels - middle;
                        let step = width * self.color.texels;
                        // The bilinear form a + b x + c y + d x y, where x and y are linear.
                        let a = at(0, 0);
                        let (b, c) = (at(1, 0) - a, at(0, 1) - a);
                        let d = at(1, 1) - a - b - c;
                        [
                            a + b * first.x + c * first.y + d * first.x * first.y,
                            b * step.x + c * step.y + d * (first.x * step.y + first.y * step.x),
                            d * step.x * step.y,
                        ]
                    }
                }
            }
        };
        [w0 * q0, w0 * q1 + w1 * q0, w0 * q2 + w1 * q1, w1 * q2]
    }

    fn transmittance(&self, at: f64) -> Vec3 {
        let place = self.start + at * self.along;
        self.coating.transmittance_at(place.x, place.y)
    }

    /// Divides a piece in which the transmittance is continuous into parts.
    fn smooth(&self, from: f64, to: f64, put: &mut impl FnMut(Passing)) {
        let value = |at: f64| self.transmittance(from + at * (to - from));
        let is_mask = matches!(self.coating.mode(), AlphaMode::Mask { .. });
        if is_mask && self.coating.transmission() == 0.0 {
            put(Passing {
                from,
                to,
                transmittance: value(0.5),
            });
            return;
        }
        // At the very ends, rounding may give the value of the next texel.
        let values = [0.02, 0.26, 0.5, 0.74, 0.98].map(value);
        let pairs = values.windows(2);
        let steepest = pairs.fold(0.0_f32, |most, pair| {
            most.max((pair[1] - pair[0]).abs().max_element())
        });
        let steps = (steepest / (0.24 * STEP)).ceil().clamp(1.0, MOST_STEPS);
        let steps = steps as u32;
        let mut last = from;
        for step in 0..steps {
            let at = |place: f64| (f64::from(step) + place) / f64::from(steps);
            let end = from + at(1.0) * (to - from);
            let end = if step + 1 < steps { end } else { to };
            // Two Gauss points give the exact mean of a cubic.
            let gauss = 0.5 / 3.0_f64.sqrt();
            put(Passing {
                from: last,
                to: end,
                transmittance: 0.5 * (value(at(0.5 - gauss)) + value(at(0.5 + gauss))),
            });
            last = end;
        }
    }
}

/// Where a cubic crosses a value between 0 and 1, in order.
fn crossings([c0, c1, c2, c3]: [f64; 4], value: f64) -> impl Iterator<Item = f64> {
    let excess = move |x: f64| ((c3 * x + c2) * x + c1) * x + (c0 - value);
    // Between two extrema it crosses the value at most once.
    let mut ends = [0.0, 1.0, 1.0, 1.0];
    let mut count = 1;
    let mut turns = turns(3.0 * c3, 2.0 * c2, c1);
    turns.sort_unstable_by(f64::total_cmp);
    for turn in turns {
        if 0.0 < turn && turn < 1.0 {
            ends[count] = turn;
            count += 1;
        }
    }
    (0..3).filter_map(move |i| {
        let (mut low, mut high) = (ends[i], ends[i + 1]);
        let is_above = excess(low) >= 0.0;
        if low == high || (excess(high) >= 0.0) == is_above {
            return None;
        }
        // Halving an interval below 1 ends at neighbouring numbers.
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return Some(high);
            }
            if (excess(middle) >= 0.0) == is_above {
                low = middle;
            } else {
                high = middle;
            }
        }
    })
}

/// The real zeros of a x² + b x + c; NaN if there are none.
fn turns(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - 4.0 * a * c).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    [q / a, c / q]
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::{Caster, Geometry, Material, Mesh, Sampler, Scene, Wrap};
    use glam::Vec4;

    fn triangle(material: Material, scale: f32, random: &mut Random) -> Geometry {
        let mut unit = || random.unit();
        let corners = [0; 3].map(|_| Vec2::new(unit(), unit()) * scale);
        let colors = [0; 3].map(|_| Vec4::new(1.0, 1.0, 1.0, 0.5 + 0.6 * unit()));
        let mut scene = Scene::from(Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            texture_coordinates: corners.to_vec(),
            colors: colors.to_vec(),
            triangles: vec![[0, 1, 2]],
            material: Some(0),
            ..Mesh::default()
        });
        scene.materials.push(material);
        Geometry::new(&scene).unwrap()
    }

    fn pattern(filter: Filter, wrap: Wrap, random: &mut Random) -> Texture {
        let mut unit = || random.unit();
        let texels = (0..20).map(|_| Vec3::new(unit(), unit(), unit())).collect();
        let texture = Texture::new(5, 4, texels).unwrap();
        let alpha = (0..20).map(|_| random.unit()).collect();
        texture.with_alpha(alpha).unwrap().with_sampler(Sampler {
            wrap: [wrap; 2],
            filter,
        })
    }

    fn parts(geometry: &Geometry, start: DVec2, end: DVec2) -> Vec<Passing> {
        let mut parts = Vec::new();
        match geometry.caster(0) {
            Caster::Masked(coating) | Caster::SeeThrough(coating) => {
                coating.along(start, end, |part| parts.push(part));
            }
            other => panic!("{other:?}"),
        }
        assert_eq!((parts[0].from, parts[parts.len() - 1].to), (0.0, 1.0));
        assert!(parts.windows(2).all(|pair| pair[0].to == pair[1].from));
        parts
    }

    #[test]
    fn parts_are_what_passes_at_each_point() {
        let mut random = Random::new(3);
        let modes = [AlphaMode::Mask { cutoff: 0.4 }, AlphaMode::Blend];
        for round in 0..240 {
            let wrap = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp][round % 3];
            let filter = [Filter::Linear, Filter::Nearest][round / 3 % 2];
            let alpha = modes[round / 6 % 2];
            let material = Material {
                base_color_texture: Some(pattern(filter, wrap, &mut random)),
                alpha,
                transmission: if round % 5 == 0 { 0.7 } else { 0.0 },
                ..Material::default()
            };
            let geometry = triangle(material, 3.0, &mut random);
            let mut place = || {
                let (a, b) = (f64::from(random.unit()), f64::from(random.unit()));
                DVec2::new(a, (1.0 - a) * b)
            };
            let (start, end) = (place(), place());
            let parts = parts(&geometry, start, end);
            for k in 0..500 {
                let at = (f64::from(k) + 0.5) / 500.0;
                let near_an_end = |part: &Passing| (part.to - at).abs() < 1e-4;
                if parts.iter().any(near_an_end) {
                    continue;
                }
                let place = (start + at * (end - start)).as_vec2();
                let expected = geometry.caster(0).transmittance(place.x, place.y);
                let part = parts.iter().find(|part| at < part.to).unwrap();
                let off = (part.transmittance - expected).abs().max_element();
                let allowed = match alpha {
                    AlphaMode::Mask { .. } if round % 5 != 0 => 0.0,
                    _ => STEP,
                };
                assert!(
                    off <= allowed,
                    "round {round}, {at}: {part:?} for {expected}"
                );
            }
        }
    }

    #[test]
    fn a_mask_of_two_texels_ends_where_their_blend_meets_the_cutoff() {
        let texture = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
        let texture = texture.with_alpha(vec![1.0, 0.0]).unwrap();
        let mut scene = Scene::from(Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            texture_coordinates: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            triangles: vec![[0, 1, 2]],
            material: Some(0),
            ..Mesh::default()
        });
        scene.materials.push(Material {
            base_color_texture: Some(texture.with_sampler(Sampler {
                wrap: [Wrap::Clamp; 2],
                filter: Filter::Linear,
            })),
            alpha: AlphaMode::Mask { cutoff: 0.3 },
            ..Material::default()
        });
        let geometry = Geometry::new(&scene).unwrap();
        let parts = parts(&geometry, DVec2::ZERO, DVec2::X);
        // From 1 at 1/4 down to 0 at 3/4.
        assert_eq!(parts.len(), 2);
        assert!((parts[0].to - 0.6).abs() < 1e-7, "{parts:?}");
        let values = parts.iter().map(|part| part.transmittance);
        assert_eq!(values.collect::<Vec<_>>(), [Vec3::ZERO, Vec3::ONE]);
    }

    #[test]
    fn lines_over_more_texels_than_can_be_told_apart_still_have_parts() {
        let mut random = Random::new(5);
        let material = Material {
            base_color_texture: Some(pattern(Filter::Linear, Wrap::Repeat, &mut random)),
            alpha: AlphaMode::Mask { cutoff: 0.4 },
            ..Material::default()
        };
        let geometry = triangle(material, 1e7, &mut random);
        let parts = parts(&geometry, DVec2::ZERO, DVec2::new(0.5, 0.4));
        assert!(parts.len() > 1000);
    }

    // Found by fuzzing.
    #[test]
    fn texture_coordinates_beyond_all_integers_have_an_opacity() {
        let mut random = Random::new(6);
        for (wrap, filter) in [
            (Wrap::Repeat, Filter::Linear),
            (Wrap::Mirror, Filter::Linear),
            (Wrap::Clamp, Filter::Nearest),
        ] {
            for scale in [1e30, -1e30, f32::MAX] {
                let material = Material {
                    base_color_texture: Some(pattern(filter, wrap, &mut random)),
                    alpha: AlphaMode::Mask { cutoff: 0.4 },
                    ..Material::default()
                };
                let geometry = triangle(material, scale, &mut random);
                let Caster::Masked(coating) = geometry.caster(0) else {
                    panic!("a mask");
                };
                let opacity = coating.opacity_at(0.3, 0.4);
                assert!((0.0..=1.1).contains(&opacity), "{opacity}");
                parts(&geometry, DVec2::ZERO, DVec2::new(0.5, 0.4));
            }
        }
    }
}
