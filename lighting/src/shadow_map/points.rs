//! Points that stand for the casters of a scene in imperfect shadow maps.
//!
//! Based on: Ritschel, Grosch, Kim, Seidel, Dachsbacher, Kautz, Imperfect Shadow
//! Maps for Efficient Computation of Indirect Illumination, SIGGRAPH Asia 2008, as
//! used by Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section
//! 3.1.2.
//!
//! Departures. The points are the same in every run. They are sorted into clusters of
//! neighbours. Any first points of a cluster are spread over all of it, so that a light can
//! take many points of near clusters and few of far ones. Wyman and Dai miss this level of
//! detail (section 5).

use glam::Vec3;
use gpu_backend::{Backend, Error, Memory};

use crate::scene::{Bounds, Caster, Geometry};

/// The largest number of points: 256 MiB of them.
const MOST_POINTS: u32 = 1 << 24;

/// Points in a cluster: few enough to lie close together.
const CLUSTER: usize = 64;

/// Points on the surfaces that cast shadows, each of which stands for the same area.
#[derive(Debug)]
pub struct CasterPoints<M: Memory> {
    points: M::Buffer<[f32; 4]>,
    clusters: Vec<Cluster>,
    bounds: Bounds,
    /// The area that a point stands for, m².
    share: f64,
}

/// Points that are neighbours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cluster {
    pub(crate) first: u32,
    pub(crate) count: u32,
    centre: Vec3,
    radius: f32,
}

/// How many points a light takes of each cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LevelOfDetail {
    /// The same share of each cluster, as in the paper.
    Even,
    /// So many that seen from the light the splats of all clusters are equally large.
    #[default]
    Near,
}

/// What a light takes of a cluster: its first `count` points, each as a splat of this area in
/// m².
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Taken {
    pub(crate) count: u32,
    pub(crate) area: f32,
}

impl<M: Memory> CasterPoints<M> {
    /// About `count` points, spread evenly over the area of all triangles. Points in the holes
    /// of masks are left out, and so are triangles that are see-through or cast no shadow.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than 2^24 points, or if the points do not fit.
    pub fn sample<B>(backend: &B, geometry: &Geometry, count: u32) -> Result<Self, Error>
    where
        B: Backend<Memory = M>,
    {
        if count > MOST_POINTS {
            let bytes = |points: u32| size_of::<[f32; 4]>() as u64 * u64::from(points);
            return Err(Error::TooLarge {
                what: "the points that stand for the casters",
                requested: bytes(count),
                limit: bytes(MOST_POINTS),
            });
        }
        let bounds = geometry.bounds();
        let (mut points, share) = spread(geometry, count);
        sort_by_place(&mut points, bounds);
        let mut clusters = Vec::with_capacity(points.len().div_ceil(CLUSTER));
        let mut ordered = Vec::with_capacity(points.len());
        for chunk in points.chunks(CLUSTER) {
            clusters.push(Cluster::around(ordered.len() as u32, chunk));
            let bits = CLUSTER.trailing_zeros();
            let order = (0..CLUSTER as u32).map(|i| (i.reverse_bits() >> (32 - bits)) as usize);
            let inside = order.filter_map(|i| chunk.get(i));
            ordered.extend(inside.map(|point| point.extend(0.0).to_array()));
        }
        Ok(Self {
            points: backend.upload(&ordered)?,
            clusters,
            bounds,
            share,
        })
    }

    /// The points, cluster by cluster; the fourth number is not used.
    pub fn points(&self) -> &M::Buffer<[f32; 4]> {
        &self.points
    }

    pub(crate) fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// A box around all casters.
    pub(crate) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// What a light at `position` takes of each cluster, about `budget` points in all.
    pub(crate) fn taken(
        &self,
        position: Option<Vec3>,
        budget: u32,
        level: LevelOfDetail,
    ) -> Vec<Taken> {
        let weights: Vec<f64> = (self.clusters.iter())
            .map(|cluster| {
                let way = match (level, position) {
                    (LevelOfDetail::Near, Some(position)) => cluster.distance(position),
                    _ => 1.0,
                };
                f64::from(cluster.count) / (way * way)
            })
            .collect();
        let scale = self.scale(&weights, f64::from(budget));
        // Fractions of points are rounded up or down by a golden-ratio sequence, so that the
        // sum is right.
        let golden = 0.5 * (5_f64.sqrt() - 1.0);
        let each = self.clusters.iter().zip(&weights).enumerate();
        each.map(|(index, (cluster, weight))| {
            let points = (scale * weight).min(cluster.count.into());
            let dither = (0.5 + index as f64 * golden).fract();
            Taken {
                count: ((points + dither) as u32).min(cluster.count),
                area: (self.share * f64::from(cluster.count) / points.max(1e-9)) as f32,
            }
        })
        .collect()
    }

    /// The factor f for which all clusters together have `wanted` points, if each takes min(f ·
    /// weight, its count); infinite if they have no more than `wanted`.
    ///
    /// A cluster is taken whole where f ≥ count / weight. Clusters are sorted by this value,
    /// the largest first, and one after the other is counted as not whole. For one number of
    /// them the f that then gives `wanted` points lies between their value and the next.
    fn scale(&self, weights: &[f64], wanted: f64) -> f64 {
        let each = self.clusters.iter().zip(weights);
        let mut clusters: Vec<[f64; 3]> = each
            .map(|(cluster, weight)| {
                let count = f64::from(cluster.count);
                [count / weight, count, *weight]
            })
            .collect();
        clusters.sort_unstable_by(|a, b| b[0].total_cmp(&a[0]));
        let mut whole: f64 = clusters.iter().map(|[_, count, _]| count).sum();
        if wanted >= whole {
            return f64::INFINITY;
        }
        let mut weights = 0.0;
        let mut next = clusters.iter().map(|[whole_from, ..]| *whole_from).skip(1);
        for [_, count, weight] in &clusters {
            whole -= count;
            weights += weight;
            let scale = (wanted - whole) / weights;
            if next.next().is_none_or(|whole_from| scale >= whole_from) {
                return scale;
            }
        }
        0.0
    }
}

impl Cluster {
    fn around(first: u32, points: &[Vec3]) -> Self {
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let centre = 0.5 * (low + high);
        let far = points.iter().map(|point| point.distance(centre));
        Self {
            first,
            count: points.len() as u32,
            centre,
            radius: far.fold(0.0, f32::max),
        }
    }

    /// The distance of its nearest point, but at least a fifth of its radius: within the
    /// cluster, a point may be anywhere.
    fn distance(&self, position: Vec3) -> f64 {
        let way = position.distance(self.centre) - self.radius;
        f64::from(way.max(0.2 * self.radius).max(1e-6))
    }
}

/// Points spread over the area of the triangles, and the area that each stands for.
fn spread(geometry: &Geometry, count: u32) -> (Vec<Vec3>, f64) {
    let triangles = geometry.triangles();
    let area = |[a, b, c]: &[Vec3; 3]| {
        let (u, v) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        0.5 * u.cross(v).length()
    };
    let casts = |index: usize| {
        let caster = geometry.coatings().caster(index);
        matches!(caster, Caster::Solid | Caster::Masked(_))
    };
    let areas = || (0..triangles.len()).filter(|index| casts(*index));
    let total: f64 = areas().map(|index| area(&triangles[index])).sum();
    if !(total > 0.0) || count == 0 {
        return (Vec::new(), 0.0);
    }
    let share = total / f64::from(count);
    // The steps of Roberts' two-dimensional sequence: 1/g and 1/g², where g³ = g + 1.
    let steps = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
    let mut points = Vec::with_capacity(count as usize);
    let (mut before, mut next) = (0.0, 0_u32);
    for index in areas() {
        let triangle = &triangles[index];
        let end = before + area(triangle);
        while next < count && (f64::from(next) + 0.5) * share <= end {
            let [mut u, mut v] = steps.map(|step| (0.5 + f64::from(next) * step).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            next += 1;
            let is_there = match geometry.coatings().caster(index) {
                Caster::Solid => true,
                masked => masked.transmittance_at(u, v) == Vec3::ZERO,
            };
            if is_there {
                let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
                points.push((a + u * (b - a) + v * (c - a)).as_vec3());
            }
        }
        before = end;
    }
    (points, share)
}

/// Sorts points along a Morton curve.
fn sort_by_place(points: &mut [Vec3], bounds: Bounds) {
    let low = bounds.min();
    let size = (bounds.max() - low).max_element().max(f32::MIN_POSITIVE);
    let spread = |number: f32| {
        let mut x = (number * 1023.0) as u32 & 1023;
        x = (x | x << 16) & 0x0300_00FF;
        x = (x | x << 8) & 0x0300_F00F;
        x = (x | x << 4) & 0x030C_30C3;
        (x | x << 2) & 0x0924_9249
    };
    let code = |point: &Vec3| {
        let [x, y, z] = ((*point - low) / size).to_array().map(spread);
        x | y << 1 | z << 2
    };
    points.sort_by_key(code);
}
