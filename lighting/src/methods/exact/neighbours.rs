//! The shadows of rays that are neighbours, found by one walk of the hierarchy.
//!
//! The planes of all rays from one eye to one light have the line from the eye to the
//! light in common, the axis: they are epipolar planes. So rays are sorted by the angle of
//! their planes around the axis, then [`STRIP`] of them at a time by their angle to it, and
//! what follows each other is asked about together:
//!
//! 1. All ways of light to the rays lie in a [`Hull`]: between their two outermost planes,
//!    on the light's side of the ray that is farthest from the axis, and between the two
//!    lines of the light that graze the nearest start and the farthest end. Boxes of the
//!    hierarchy outside of it are left out for all rays at once.
//! 2. All planes are drawn on top of each other, a caster as its [`Sight`]: between which
//!    lines of the light it is, and how near to the axis as the eye sees it. Along each ray
//!    that is an interval in which the caster's shadow lies, at the price of two divisions.
//! 3. Boxes that are dark along one ray may not be along the next. The ray that last had
//!    something to learn is asked first, and most boxes are found to be wanted by it; a box
//!    is left out if no ray has anything to learn of it.
//! 4. A triangle is cut by the planes between its corners, which are found by their angle,
//!    and of these only where its sight is not dark already.
//!
//! What a triangle takes from a ray is computed as for a ray by itself, and a [`Shadow`]
//! does not depend on the order of blockers nor on blockers that are too many. So lit parts
//! have the same bits, whatever rays are asked together: no triangle is left out that takes
//! anything of a ray, as hull, angles and sights have margins of 10⁻⁹ of the size of the
//! numbers that go into them. Positions are rounded to 10⁻¹⁵ of that; the normals of planes
//! to 10⁻¹² at worst, as rays at less than [`NARROWEST`] to the axis are asked by themselves.

use std::borrow::Borrow;
use std::cell::RefCell;

use glam::{DVec2, DVec3};

use super::plane::Plane;
use super::shadow::Shadow;
use super::{Exact, darken};
use crate::hull::{Hull, MARGIN, Place};
use crate::scene::trace::Tracer;
use crate::scene::{Caster, Emitter};
use crate::{LightPath, Ray};

/// Rays that are sorted by the angle to the light: so many, in planes next to each other,
/// are a strip of a pixel or two across the picture.
const STRIP: usize = 256;

/// Planes of one walk differ by no more than this, radians.
const WIDEST: f64 = 1.0;

/// The largest rounding error of places on a ray, relative to these and to the distance of the
/// light.
const ROUNDING: f64 = 1e-12;

/// Rays closer to the direction of the light, radians, have planes whose normals rounding
/// turns, and are asked by themselves.
const NARROWEST: f64 = 1e-4;

/// The numbers of rays from one eye, neighbours one after the other.
pub(super) fn in_order(rays: &[Ray], emitter: &Emitter) -> Option<Vec<u32>> {
    let eye = rays.first()?.origin();
    if rays.iter().any(|ray| ray.origin() != eye) {
        return None;
    }
    let sheaf = Sheaf::new(eye.as_dvec3(), emitter)?;
    let [axis, x, y] = [sheaf.axis, sheaf.x, sheaf.y].map(|axis| axis.as_vec3());
    // More rays than a u32 counts do not fit into memory.
    let mut keys: Vec<u64> = (rays.iter().zip(0_u32..))
        .map(|(ray, index)| {
            let turn = turn(ray.direction().dot(x), ray.direction().dot(y));
            (u64::from(turn) << 32) | u64::from(index)
        })
        .collect();
    keys.sort_unstable();
    let mut order: Vec<u32> = keys.into_iter().map(|key| key as u32).collect();
    for strip in order.chunks_mut(STRIP) {
        strip.sort_by_cached_key(|ray| {
            let cosine = rays[*ray as usize].direction().dot(axis);
            turn(cosine, (1.0 - cosine * cosine).max(0.0))
        });
    }
    Some(order)
}

/// A number that grows with the angle from −π to π of a direction.
fn turn(x: f32, y: f32) -> u32 {
    let along = y / (x.abs() + y.abs());
    let quarters = match x >= 0.0 {
        true => along,
        false => 2.0_f32.copysign(y) - along,
    };
    ((quarters + 2.0) * 2.0_f32.powi(30)) as u32
}

/// The planes that have the line from an eye to a light in common.
struct Sheaf {
    /// Towards the light.
    axis: DVec3,
    x: DVec3,
    y: DVec3,
    light: Place,
}

impl Sheaf {
    /// `None` if the eye is at the light.
    fn new(eye: DVec3, emitter: &Emitter) -> Option<Self> {
        let light = Place::of(emitter, eye);
        let axis = light.from(DVec3::ZERO).try_normalize()?;
        let x = axis.any_orthonormal_vector();
        Some(Self {
            axis,
            x,
            y: axis.cross(x),
            light,
        })
    }
}

/// A ray in its plane.
struct Member {
    /// The number of its path.
    path: usize,
    /// Of its plane in the sheaf, from −π to π.
    angle: f64,
    plane: Plane,
    start: f64,
    end: f64,
    shadow: Shadow,
    /// Whether the shadow is whole.
    is_dark: bool,
}

impl<T: Borrow<Tracer>> Exact<T> {
    /// Calls `found` with the number of each path and its shadow, in any order.
    pub(super) fn shadows_together(
        &self,
        paths: &[LightPath<'_>],
        mut found: impl FnMut(usize, Shadow),
    ) {
        let Some(first) = paths.first() else {
            return;
        };
        let eye = first.ray().origin();
        let sheaf = Sheaf::new(eye.as_dvec3(), first.emitter());
        let mut members = Vec::with_capacity(paths.len());
        for (number, path) in paths.iter().enumerate() {
            let is_of_sheaf =
                path.ray().origin() == eye && std::ptr::eq(path.emitter(), first.emitter());
            let sheaf = sheaf.as_ref().filter(|_| is_of_sheaf);
            match sheaf.and_then(|sheaf| Member::new(sheaf, number, path)) {
                Some(member) => members.push(member),
                None => found(number, self.shadow(path)),
            }
        }
        members.sort_unstable_by(|a, b| a.angle.total_cmp(&b.angle));
        if let Some(sheaf) = sheaf {
            let mut others = &mut members[..];
            while let Some(first) = others.first() {
                let widest = first.angle + WIDEST;
                let count = others.partition_point(|member| member.angle <= widest);
                let (fan, rest) = others.split_at_mut(count);
                Fan::new(&sheaf, fan).walk(self.tracer.borrow());
                others = rest;
            }
        }
        for member in members {
            found(member.path, member.shadow);
        }
    }
}

impl Member {
    /// `None` for a ray towards the light or away from it.
    fn new(sheaf: &Sheaf, number: usize, path: &LightPath<'_>) -> Option<Self> {
        let plane = Plane::new(path)?;
        let across = DVec2::new(plane.along().dot(sheaf.x), plane.along().dot(sheaf.y));
        (across.length() >= NARROWEST).then(|| Self {
            path: number,
            angle: across.y.atan2(across.x),
            plane,
            start: f64::from(path.span().start),
            end: f64::from(path.span().end),
            shadow: Shadow::new(path),
            is_dark: false,
        })
    }
}

/// The direction of a ray on the middle plane of a fan.
#[derive(Debug, Clone, Copy)]
struct Way {
    /// Along the axis.
    axial: f64,
    /// Away from it.
    across: f64,
}

/// The largest part that a caster can hide from the light, in planes on top of each other: it is
/// at heights `μ` above the axis and at distances `z` along it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
struct Sight {
    /// Between which lines of the light it is: cotangents `(z − l) / μ` of their angles for
    /// a light at the distance `l`, their heights for a sun.
    lines: [f64; 2],
    /// The largest cotangent `z / μ` at the eye: it is beyond rays of a larger one.
    from_eye: f64,
}

impl Sight {
    /// The sight of a caster of which nothing is known.
    const ALL: Self = Self {
        lines: [f64::NEG_INFINITY, f64::INFINITY],
        from_eye: f64::INFINITY,
    };

    /// The sight of two casters together.
    fn with(self, other: Self) -> Self {
        Self {
            lines: [
                self.lines[0].min(other.lines[0]),
                self.lines[1].max(other.lines[1]),
            ],
            from_eye: self.from_eye.max(other.from_eye),
        }
    }
}

/// Rays in planes close to each other. Positions are relative to the eye.
struct Fan<'a> {
    /// By the angles of their planes.
    members: &'a mut [Member],
    /// The directions of their rays.
    ways: Vec<Way>,
    /// Tangents of the angles, from the middle one on.
    slopes: Vec<f64>,
    /// Away from the eye, towards the light.
    axis: DVec3,
    /// How far the light is.
    distance: f64,
    /// Away from the axis in the middle plane.
    middle: DVec3,
    /// Across it, towards larger angles.
    side: DVec3,
    hull: Hull,
    /// The ray that last had something to learn.
    last: usize,
}

impl<'a> Fan<'a> {
    fn new(sheaf: &Sheaf, members: &'a mut [Member]) -> Self {
        let angle = 0.5 * (members[0].angle + members[members.len() - 1].angle);
        let (sin, cos) = angle.sin_cos();
        let middle = cos * sheaf.x + sin * sheaf.y;
        let side = sheaf.axis.cross(middle);
        let slope = |member: &Member| {
            let along = member.plane.along();
            along.dot(side) / along.dot(middle)
        };
        let slopes: Vec<f64> = members.iter().map(slope).collect();
        let way = |member: &Member| {
            let along = member.plane.along();
            Way {
                axial: along.dot(sheaf.axis),
                across: along.dot(middle),
            }
        };
        let ways: Vec<Way> = members.iter().map(way).collect();
        let ends = |member: &Member| {
            [member.start, member.end].map(|x| Place::on_ray(member.plane.along(), x))
        };
        let mut places: Vec<Place> = members.iter().flat_map(ends).collect();
        places.push(sheaf.light);
        let normals = normals(sheaf, [middle, side], &ways, &places, &slopes);
        Self {
            members,
            ways,
            slopes,
            axis: sheaf.axis,
            distance: match sheaf.light {
                Place::At(light) => light.length(),
                Place::Towards(_) => f64::INFINITY,
            },
            middle,
            side,
            hull: Hull::new(normals, &places),
            last: 0,
        }
    }

    fn walk(self, tracer: &Tracer) {
        let Some(first) = self.members.first() else {
            return;
        };
        let eye = first.plane.eye();
        // The closures of the walk share the shadows found so far.
        let fan = RefCell::new(self);
        tracer.walk(
            |centre, half| {
                let mut fan = fan.borrow_mut();
                let offset = centre - eye;
                if !fan.hull.may_meet_box(offset, half) {
                    return None;
                }
                let sight = fan.sight_of_box(offset, half);
                fan.wants(&sight).map(|size| (size, sight))
            },
            |(_, sight)| fan.borrow_mut().wants(&sight).is_none(),
            |triangle, index| {
                let corners = triangle.map(|corner| corner.as_dvec3() - eye);
                let caster = tracer.coatings().caster(index);
                fan.borrow_mut().darken(&corners, caster);
            },
        );
    }

    /// How much of a ray that wants it a box may darken; `None` if none wants it.
    fn wants(&mut self, sight: &Sight) -> Option<f64> {
        let count = self.members.len();
        let numbers = (self.last..count).chain(0..self.last);
        let (number, size) = numbers
            .filter_map(|number| Some((number, self.hidden(number, sight)?)))
            .next()?;
        self.last = number;
        Some(size)
    }

    /// How much of a ray a caster may still darken; `None` if nothing.
    #[inline]
    fn hidden(&self, number: usize, sight: &Sight) -> Option<f64> {
        let member = &self.members[number];
        let Way { axial, across } = self.ways[number];
        if member.is_dark || sight.from_eye * across < axial {
            return None;
        }
        let [from, to] = sight.lines;
        let (a, b) = if self.distance.is_finite() {
            // The positions at which lines from the light meet the ray, if they meet it.
            let [from, to] = [axial - across * from, axial - across * to];
            if from <= 0.0 {
                return None;
            }
            let b = if to > 0.0 {
                self.distance / to
            } else {
                f64::INFINITY
            };
            let a = self.distance / from;
            (
                a - ROUNDING * (self.distance + a),
                b + ROUNDING * (self.distance + b),
            )
        } else {
            (from / across, to / across)
        };
        let (a, b) = member.shadow.clip(a, b)?;
        (!member.shadow.covers(a, b)).then_some(b - a)
    }

    /// The largest part that anything in a box can hide.
    fn sight_of_box(&self, offset: DVec3, half: DVec3) -> Sight {
        let margin = self.margin(offset.abs().max_element() + half.max_element());
        let range = |axis: DVec3| {
            let (at, reach) = (axis.dot(offset), axis.abs().dot(half) + margin);
            [at - reach, at + reach]
        };
        self.sight(range(self.axis), range(self.middle))
    }

    /// The largest part that a triangle can hide.
    fn sight_of_triangle(&self, corners: &[DVec3; 3]) -> Sight {
        let [a, b, c] = corners.map(|corner| {
            let margin = self.margin(corner.abs().max_element());
            let around = |at: f64| [at - margin, at + margin];
            self.sight(
                around(self.axis.dot(corner)),
                around(self.middle.dot(corner)),
            )
        });
        a.with(b).with(c)
    }

    /// The largest part that anything in a rectangle of the middle plane can hide.
    fn sight(&self, [near, far]: [f64; 2], [low, high]: [f64; 2]) -> Sight {
        if low <= 0.0 {
            return Sight::ALL;
        }
        let least = |z: f64| z / if z < 0.0 { low } else { high };
        let most = |z: f64| z / if z > 0.0 { low } else { high };
        Sight {
            lines: match self.distance.is_finite() {
                true => [least(near - self.distance), most(far - self.distance)],
                false => [low, high],
            },
            from_eye: most(far),
        }
    }

    /// How much places of this size are widened.
    fn margin(&self, size: f64) -> f64 {
        let distance = Some(self.distance).filter(|distance| distance.is_finite());
        MARGIN * (size + distance.unwrap_or(0.0))
    }

    /// Adds what a caster takes from the rays.
    fn darken(&mut self, corners: &[DVec3; 3], caster: Caster<'_>) {
        if caster == Caster::Absent || !self.hull.may_meet_triangle(corners) {
            return;
        }
        let [least, most] = self.slopes_of(corners);
        let first = self.slopes.partition_point(|slope| *slope < least);
        let slopes = self.slopes[first..].iter();
        let count = slopes.take_while(|slope| **slope <= most).count();
        if count == 0 {
            return;
        }
        let sight = self.sight_of_triangle(corners);
        for number in first..first + count {
            if self.hidden(number, &sight).is_some() {
                let member = &mut self.members[number];
                darken(&mut member.shadow, &member.plane, corners, caster);
                member.is_dark = member.shadow.is_whole();
            }
        }
    }

    /// Between which slopes the planes are that may cut a triangle before the axis.
    fn slopes_of(&self, corners: &[DVec3; 3]) -> [f64; 2] {
        let mut slopes = [f64::INFINITY, f64::NEG_INFINITY];
        for corner in corners {
            let (p, q) = (self.middle.dot(*corner), self.side.dot(*corner));
            let margin = MARGIN * corner.abs().max_element();
            if p <= margin {
                return [f64::NEG_INFINITY, f64::INFINITY];
            }
            let (slope, margin) = (q / p, margin * (1.0 + (q / p).abs()) / p);
            slopes[0] = slopes[0].min(slope - margin);
            slopes[1] = slopes[1].max(slope + margin);
        }
        slopes
    }
}

/// Normals of the planes around the ways of light to a fan.
fn normals(
    sheaf: &Sheaf,
    [middle, side]: [DVec3; 2],
    ways: &[Way],
    places: &[Place],
    slopes: &[f64],
) -> Vec<DVec3> {
    let (first, last) = (slopes[0], slopes[slopes.len() - 1]);
    let axis = sheaf.axis;
    let cotangents = ways.iter().map(|way| way.axial / way.across);
    let farthest = cotangents.fold(f64::INFINITY, f64::min);
    let grazing = match sheaf.light {
        Place::Towards(_) => [middle, -middle],
        Place::At(light) => {
            let mut range = [f64::INFINITY, f64::NEG_INFINITY];
            for place in &places[..places.len() - 1] {
                let way = place.from(light);
                let cotangent = way.dot(axis) / way.dot(middle).max(0.0);
                range = [range[0].min(cotangent), range[1].max(cotangent)];
            }
            [axis - range[1] * middle, range[0] * middle - axis]
        }
    };
    [
        side - last * middle,
        first * middle - side,
        farthest * middle - axis,
    ]
    .into_iter()
    .chain(grazing)
    .filter_map(DVec3::try_normalize)
    .collect()
}
