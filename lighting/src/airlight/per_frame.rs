//! Airlight tables that are made for one frame.

use airlight::{Error, FramePoint, FrameRay, FrameTable};
use glam::Vec3;

use super::analytic::by_cone;
use super::{AirlightEvaluator, Quadrature};
use crate::path::full_cone;
use crate::scene::{Emitter, Medium};
use crate::{Interval, LightPath};

/// The tables of [`airlight::FrameTable`] for one eye and one light, one for each extinction,
/// with a quadrature as the fallback.
///
/// The tables serve point lights inside the medium that shine alike in all directions and do
/// not fade, and, of a spotlight without a cookie, the part of a ray in its full cone. In a box
/// of fog the light is scaled, because the air between the eye and the box absorbs nothing.
///
/// The quadrature serves everything else: other lights, rays from other eyes, media with
/// another extinction, lights more than [`FrameTable::DEEPEST`] mean free paths from the eye,
/// and parts that a table does not cover, such as short ones behind much light, far ones in
/// thick fog, and directions in which the phase function is too sharp for the rows. So the
/// result is always within the errors of [`FrameTable`] and of the quadrature, but where the
/// tables do not serve it takes as long as the quadrature.
///
/// Phase functions are not compared: the medium that is evaluated must have the phase function
/// that the tables and the quadrature were made for.
#[derive(Debug, Clone)]
pub struct PerFrame {
    /// No table, one for all channels, or one for each channel.
    tables: Vec<FrameTable>,
    fallback: Quadrature,
}

/// What the tables hold for a position on a ray, in each channel.
type Points = [Option<FramePoint>; 3];

impl PerFrame {
    /// Without tables: the fallback evaluates everything.
    pub fn new(fallback: Quadrature) -> Self {
        Self {
            tables: Vec::new(),
            fallback,
        }
    }

    /// With the tables of a light as the eye sees it, of `rows` rows; without any if tables do
    /// not serve the light or the eye. See [`FrameTable::new`].
    ///
    /// # Errors
    /// [`Error::BadValue`] if the number of rows is out of range.
    pub fn of_light(
        fallback: Quadrature,
        eye: Vec3,
        light: &Emitter,
        medium: &Medium,
        rows: u32,
    ) -> Result<Self, Error> {
        // A bad number of rows is an error whatever the light is.
        let phase = medium.phase();
        FrameTable::check_rows(rows)?;
        let Emitter::Point(point) = light else {
            return Ok(Self::new(fallback));
        };
        let is_plain = point.is_plain() || full_cone(point, medium).is_some();
        let is_immersed = (medium.bounds()).is_none_or(|bounds| bounds.contains(point.position()));
        let distance = (point.position().as_dvec3() - eye.as_dvec3()).length() as f32;
        let sigma_t = medium.sigma_t();
        let depth = sigma_t.max_element() * distance;
        let is_in_range = (1e-9..=1e9).contains(&distance) && depth <= FrameTable::DEEPEST;
        if !(is_plain && is_immersed && is_in_range) {
            return Ok(Self::new(fallback));
        }
        let channels = if sigma_t == Vec3::splat(sigma_t.x) {
            1
        } else {
            3
        };
        let sigmas = sigma_t.to_array().into_iter().take(channels);
        let tables = sigmas.map(|sigma| FrameTable::new(&phase, sigma, distance, rows));
        Ok(Self {
            tables: tables.collect::<Result<_, _>>()?,
            fallback,
        })
    }

    /// The tables: none, one for all channels of a grey medium, or three.
    pub fn tables(&self) -> &[FrameTable] {
        &self.tables
    }

    /// The quadrature that is used where the tables do not serve.
    pub fn fallback(&self) -> &Quadrature {
        &self.fallback
    }

    /// Size of the tables in bytes.
    pub fn bytes(&self) -> usize {
        self.tables.iter().map(FrameTable::bytes).sum()
    }

    fn rays(&self, path: &LightPath<'_>) -> [Option<FrameRay<'_>>; 3] {
        let sigma_t = path.medium().sigma_t();
        let is_grey = sigma_t == Vec3::splat(sigma_t.x);
        let ray = |i: usize| {
            let table = self.tables.get(i)?;
            let is_of_table = table.sigma_t() == sigma_t[i] && (is_grey || self.tables.len() > 1);
            is_of_table
                .then(|| table.ray(path.foot(), path.h()))
                .flatten()
        };
        [ray(0), ray(1), ray(2)]
    }

    /// The radiance between two positions for a light that the tables serve; `None` where a
    /// table does not cover it.
    fn between(
        &self,
        path: &LightPath<'_>,
        rays: &[Option<FrameRay<'_>>; 3],
        start: &Points,
        end: &Points,
    ) -> Option<Vec3> {
        let channel = |i: usize| {
            let (ray, start, end) = (rays[i]?, start[i]?, end[i]?);
            let airlight = ray.between(&start, &end)?;
            // The air between the eye and a box of fog absorbs nothing.
            let clear = self.tables[i].sigma_t() * path.entry();
            match clear > 0.0 {
                false => Some(airlight),
                true if clear <= FrameTable::DEEPEST => Some(airlight * clear.exp()),
                true => None,
            }
        };
        let red = channel(0)?;
        let airlight = match self.tables.len() {
            1 => Vec3::splat(red),
            _ => Vec3::new(red, channel(1)?, channel(2)?),
        };
        Some(path.medium().sigma_s() * path.emitter().intensity() * airlight)
    }

    /// The radiance of a part in which the light shines alike in all directions.
    fn plain(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        let rays = self.rays(path);
        let [start, end] = [interval.start, interval.end].map(|x| points(&rays, x));
        let known = (interval.start < interval.end)
            .then(|| self.between(path, &rays, &start, &end))
            .flatten();
        known.unwrap_or_else(|| self.fallback.radiance(path, interval))
    }
}

fn points(rays: &[Option<FrameRay<'_>>; 3], x: f32) -> Points {
    rays.map(|ray| ray?.at(x))
}

impl AirlightEvaluator for PerFrame {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        if self.tables.is_empty() {
            return self.fallback.radiance(path, interval);
        }
        by_cone(
            path,
            interval,
            |piece| self.plain(path, piece),
            |piece| self.fallback.radiance(path, piece),
        )
    }

    /// A step that begins where the one before it ended takes a single lookup.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        let mut ray = None;
        let mut last: Option<(f32, Points)> = None;
        for &(index, interval) in parts {
            let path = &paths[index];
            let is_plain = !self.tables.is_empty() && path.segment(interval).is_some();
            if !(is_plain && interval.start < interval.end) {
                radiances.push(self.radiance(path, interval));
                continue;
            }
            let rays = match &ray {
                Some((of, rays)) if *of == index => rays,
                _ => {
                    last = None;
                    &ray.insert((index, self.rays(path))).1
                }
            };
            let start = match last {
                Some((x, start)) if x == interval.start => start,
                _ => points(rays, interval.start),
            };
            let end = points(rays, interval.end);
            last = Some((interval.end, end));
            let known = self.between(path, rays, &start, &end);
            radiances.push(known.unwrap_or_else(|| self.fallback.radiance(path, interval)));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::Ray;
    use crate::airlight::Analytic;
    use crate::scene::{Bounds, Cone, Emission, PhaseFunction};

    const PHASE: PhaseFunction = PhaseFunction::HenyeyGreenstein { g: 0.5 };

    fn rays(eye: Vec3) -> Vec<Ray> {
        (0..60)
            .map(|i| {
                let angle = 0.11 * i as f32;
                let towards = Vec3::new(angle.sin(), 0.3 * (0.7 * angle).cos(), -angle.cos());
                let length = if i % 4 == 0 { f32::INFINITY } else { 7.0 };
                Ray::new(eye, towards, length).unwrap()
            })
            .collect()
    }

    /// Plain lights and spotlights in fog that ends and fog that does not, seen from the
    /// eye of the tables and from elsewhere, from inside of the box and outside of it:
    /// everything is as near double precision as the table.
    #[test]
    fn tables_of_a_frame_stand_for_every_ray() {
        let sigma = Vec3::new(0.05, 0.1, 0.2);
        let open = Medium::new(sigma, 0.2 * sigma, PHASE).unwrap();
        let bounds = Bounds::new(Vec3::new(-3.0, -2.0, -9.0), Vec3::new(3.0, 2.5, -1.0)).unwrap();
        let grey = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PHASE).unwrap();
        let cone = Cone {
            inner: 0.4,
            outer: 0.6,
        };
        let down = Quat::from_rotation_x(-1.4);
        let spot = Emission::spot(down, cone, None).unwrap();
        let at = Vec3::new(0.2, 0.4, -4.0);
        let fallback = Quadrature::with_tolerance(PHASE, 1e-6).unwrap();
        let double = Analytic::new(airlight::Exact::new(PHASE).unwrap(), fallback.clone());
        for emission in [Emission::Isotropic, spot] {
            let light = Emitter::point(at, Vec3::new(1.0, 2.0, 3.0), f32::INFINITY, emission);
            let light = light.unwrap();
            for medium in [open, open.within(bounds), grey] {
                let eye = Vec3::new(0.1, 0.0, 0.5);
                let of_eye =
                    PerFrame::of_light(fallback.clone(), eye, &light, &medium, 256).unwrap();
                let tables = if medium == grey { 1 } else { 3 };
                assert_eq!(of_eye.tables().len(), tables);
                let mut compared = 0;
                for from in [eye, Vec3::new(0.0, 0.0, -3.0)] {
                    for ray in rays(from) {
                        let Some(path) = LightPath::new(&ray, &light, &medium) else {
                            continue;
                        };
                        let path = path.off_the_light();
                        let span = path.span();
                        let middle = span.start + 0.3 * span.end.min(9.0);
                        for part in [
                            span,
                            Interval::new(span.start, middle),
                            Interval::new(middle, middle + 0.05),
                            Interval::new(middle, span.end),
                        ] {
                            let truth = double.radiance(&path, part);
                            let error = (of_eye.radiance(&path, part) / truth - 1.0).abs();
                            let is_dark = truth.max_element() < 1e-20;
                            assert!(is_dark || error.max_element() < 2e-3, "{part:?}: {error}");
                            compared += 1;
                        }
                    }
                }
                assert!(compared > 20, "{compared}");
            }
        }
    }

    #[test]
    fn lights_and_eyes_without_tables_are_integrated() {
        let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PHASE).unwrap();
        let fallback = Quadrature::with_tolerance(PHASE, 1e-4).unwrap();
        let point = |emission| Emitter::point(Vec3::Z, Vec3::ONE, 9.0, emission).unwrap();
        let surface = Emission::Cosine {
            normal: Vec3::NEG_Z,
        };
        let of = |light: &Emitter, eye: Vec3| {
            let made = PerFrame::of_light(fallback.clone(), eye, light, &fog, 64).unwrap();
            made.tables().len()
        };
        let plain = point(Emission::Isotropic);
        assert_eq!(of(&plain, Vec3::ZERO), 1);
        assert_eq!(of(&plain, Vec3::Z), 0);
        assert_eq!(of(&plain, 1e3 * Vec3::Z), 0);
        assert_eq!(of(&point(surface), Vec3::ZERO), 0);
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        assert_eq!(of(&sun, Vec3::ZERO), 0);
        assert!(PerFrame::of_light(fallback, Vec3::ZERO, &sun, &fog, 7).is_err());
    }

    /// Media of another extinction are the fallback's, in any channel.
    #[test]
    fn tables_are_not_asked_for_other_media() {
        let fallback = Quadrature::with_tolerance(PHASE, 1e-4).unwrap();
        let light = Emitter::point(Vec3::NEG_Z, Vec3::ONE, f32::INFINITY, Emission::Isotropic);
        let light = light.unwrap();
        let sigmas = [
            Vec3::splat(0.1),
            Vec3::splat(0.2),
            Vec3::new(0.1, 0.1, 0.2),
            Vec3::new(0.1, 0.2, 0.2),
        ];
        let media = sigmas.map(|sigma| Medium::new(sigma, Vec3::ZERO, PHASE).unwrap());
        let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0), 5.0).unwrap();
        let part = Interval::new(0.0, 2.0);
        for (i, of_tables) in media.iter().enumerate() {
            let tables = PerFrame::of_light(fallback.clone(), Vec3::ZERO, &light, of_tables, 64);
            let tables = tables.unwrap();
            for (j, medium) in media.iter().enumerate() {
                let path = LightPath::new(&ray, &light, medium).unwrap();
                let found = tables.radiance(&path, part);
                let is_of_fallback = found == fallback.radiance(&path, part);
                assert_eq!(is_of_fallback, i != j, "{i} {j}");
                let mut steps = Vec::new();
                tables.radiances(&[path], &[(0, part)], &mut steps);
                assert_eq!(steps, [found], "{i} {j}");
            }
        }
    }
}
