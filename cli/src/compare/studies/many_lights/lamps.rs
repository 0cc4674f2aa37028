//! Lamps in the air of a view, and how many of them reach its pixels.

use std::f32::consts::PI;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::culling::{Clusters, RayTiles, TileLights};
use lighting::scene::view::View;
use lighting::scene::{Emission, Medium};
use lighting::{Emitter, LightPath, Ray};
use reference::random::Random;

use crate::failure::Failure;

/// How the ranges of lamps are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Crowd {
    /// So that on average [`REACH`] of them reach a pixel.
    Constant,
    /// As large as if there were 1000 of them, so that more reach a pixel if there are more.
    Growing,
}

/// About how many lamps reach a pixel.
const REACH: f32 = 8.0;

pub(super) struct Lamps {
    pub(super) emitters: Vec<Emitter>,
    pub(super) tiles: RayTiles,
}

/// Pairs of a pixel and a light, and pixels with surfaces.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    pub(super) reach: u64,
    pub(super) listed: u64,
    /// Pairs of a light and the surface that a pixel shows: those within the light's range, those
    /// in the cluster's list, and those in the tile's list.
    pub(super) lit: u64,
    pub(super) by_clusters: u64,
    pub(super) by_tiles: u64,
    pub(super) surfaces: u64,
}

impl Lamps {
    /// Places `count` lamps on rays that end on a surface.
    pub(super) fn new(view: &View, width: u32, crowd: Crowd, count: u32) -> Result<Self, Failure> {
        let rays = view.rays();
        let ends: Vec<&Ray> = rays.iter().filter(|ray| ray.length().is_finite()).collect();
        // The discs of this many lamps cover the view [`REACH`] times.
        let of = match crowd {
            Crowd::Constant => count,
            Crowd::Growing => 1000,
        };
        let radius = (REACH * solid_angle(view) / (PI * of as f32)).sqrt();
        let mut random = Random::new(19);
        let emitters = (0..count).map(|_| {
            let ray = ends[random.below(ends.len() as u32) as usize];
            let distance = ray.length() * (0.2 + 0.8 * random.unit());
            let colour = Vec3::new(1.0, 0.8, 0.6) * distance * distance / count as f32;
            let range = radius * distance;
            Emitter::point(ray.at(distance), colour, range, Emission::Isotropic)
        });
        let emitters = emitters.collect::<Result<_, _>>()?;
        let tiles = RayTiles::new(&Cpu::new(), rays, width, None)
            .ok_or_else(|| Failure::new("the rays of the view do not start at one eye"))?;
        Ok(Self { emitters, tiles })
    }

    /// Counts the lights of each pixel.
    pub(super) fn count(&self, view: &View, medium: &Medium, clusters: &Clusters<'_>) -> Counts {
        let lists: &TileLights<'_> = clusters.rays();
        let of_pixel = |pixel: usize| {
            let ray = &view.rays()[pixel];
            // The lists leave out no light that reaches the ray.
            let light = |light: u32| &self.emitters[light as usize];
            let listed: Vec<u32> = lists.of_ray(pixel, ray.length()).collect();
            let reach = listed
                .iter()
                .filter(|number| LightPath::new(ray, light(**number), medium).is_some());
            let mut counts = Counts {
                reach: reach.count() as u64,
                listed: listed.len() as u64,
                ..Counts::default()
            };
            if ray.length().is_finite() {
                let point = ray.at(ray.length());
                let near: Vec<u32> = clusters.at(pixel, ray.length()).collect();
                let is_lit = |number: &&u32| match light(**number) {
                    Emitter::Point(lamp) => lamp.position().distance(point) <= lamp.range(),
                    Emitter::Directional(_) => true,
                };
                counts.lit = near.iter().filter(is_lit).count() as u64;
                counts.by_clusters = near.len() as u64;
                let tile = self.tiles.tile_of(pixel);
                counts.by_tiles = tile.map_or(0, |tile| lists.of_tile(tile).len() as u64);
                counts.surfaces = 1;
            }
            counts
        };
        let all = Cpu::new().map(view.rays().len(), of_pixel);
        all.into_iter()
            .fold(Counts::default(), |sum, counts| Counts {
                reach: sum.reach + counts.reach,
                listed: sum.listed + counts.listed,
                lit: sum.lit + counts.lit,
                by_clusters: sum.by_clusters + counts.by_clusters,
                by_tiles: sum.by_tiles + counts.by_tiles,
                surfaces: sum.surfaces + counts.surfaces,
            })
    }
}

/// About the solid angle of a view: that of the rectangle between its corners, as if it were
/// flat.
fn solid_angle(view: &View) -> f32 {
    let (width, height) = (view.width() as usize, view.height() as usize);
    let rays = view.rays();
    let last = rays.len() - 1;
    let corner = |i: usize| rays[i].direction();
    let across = corner(0).distance(corner(width - 1));
    let down = corner(0).distance(corner(last + 1 - width));
    // The corners are the centres of the outermost pixels.
    let whole = |extent: f32, pixels: usize| extent * pixels as f32 / (pixels - 1).max(1) as f32;
    whole(across, width) * whole(down, height)
}
