//! The parts of each pixel that strands cover.

use std::cmp::Ordering;

use gpu_backend::Cpu;
use transmittance::{BlockerSegment, Stream, Tile};

use crate::methods::translucent::bins::Bins;
use crate::methods::translucent::strands::{Covered, Outline};
use crate::methods::translucent::view::View as Picture;
use crate::scene::view::{Cover, CoverStep, View};
use crate::scene::{Camera, Piece, Strands, Translucent};

/// The strands of a scene over the pixels of a view: the fragments of each pixel, the nearest
/// first. See the page of [this module](super).
#[derive(Debug, Clone, PartialEq)]
pub struct SeenHair {
    /// For each pixel, the index behind its last fragment.
    ends: Vec<usize>,
    fragments: Vec<Fragment>,
}

/// The part of a pixel that a strand covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fragment {
    /// Distance from the eye, m.
    pub(super) distance: f32,
    /// The share of the light from behind that it holds back.
    pub(super) alpha: f32,
    /// The index of its strands among the scene's translucent casters, and of its piece.
    pub(super) caster: u32,
    pub(super) piece: u32,
    /// The position along the piece.
    pub(super) share: f32,
}

/// Pixels along each side of a unit of work.
const SIDE: usize = 16;

/// Fragments behind which less than this share of the light is left are not looked at.
const HIDDEN: f32 = 1e-4;

/// The transmittance curve of a pixel, with up to 16 nodes.
type Nodes = Stream<16>;

impl SeenHair {
    /// The strands in `translucent` that `view` shows in front of its surfaces; `camera` must
    /// be the camera of the view. `None` if there are no strands.
    ///
    /// The cost is proportional to the number of fragments plus the number of pieces.
    pub fn new(
        cpu: &Cpu,
        camera: &Camera,
        view: &View,
        translucent: &[Translucent],
    ) -> Option<Self> {
        let [width, height] = [view.width(), view.height()];
        let picture = Picture::of_camera(camera, [width, height]);
        let layers: Vec<(u32, &Strands, Bins)> = (0..)
            .zip(translucent)
            .filter_map(|(caster, translucent)| {
                let Translucent::Strands(strands) = translucent else {
                    return None;
                };
                let texels = |piece: usize| {
                    let outline = Outline::new(&picture, &strands.piece(piece))?;
                    outline.texels(&picture)
                };
                let bins = Bins::new(width.max(height), strands.piece_count(), texels);
                Some((caster, strands, bins))
            })
            .collect();
        if layers.is_empty() {
            return None;
        }
        let seen = Layers {
            picture,
            translucent,
            layers,
            view,
        };
        let [columns, rows] = [width, height].map(|side| (side as usize).div_ceil(SIDE));
        let tiles = cpu.map(columns * rows, |tile| {
            let at = |tile: usize, side: u32| SIDE * tile..(SIDE * (tile + 1)).min(side as usize);
            seen.of_tile(&Tile {
                x: at(tile % columns, width),
                y: at(tile / columns, height),
            })
        });
        let mut seen = Self {
            ends: Vec::with_capacity(view.rays().len()),
            fragments: Vec::with_capacity(tiles.iter().map(|tile| tile.fragments.len()).sum()),
        };
        for y in 0..height as usize {
            for x in 0..width as usize {
                let tile = &tiles[y / SIDE * columns + x / SIDE];
                seen.fragments.extend(tile.of(y % SIDE * SIDE + x % SIDE));
                seen.ends.push(seen.fragments.len());
            }
        }
        Some(seen)
    }

    /// Number of fragments.
    pub fn len(&self) -> usize {
        self.fragments.len()
    }

    /// Number of pixels, with or without strands.
    pub(super) fn pixels(&self) -> usize {
        self.ends.len()
    }

    /// True if no pixel shows any strand.
    pub fn is_empty(&self) -> bool {
        self.fragments.is_empty()
    }

    /// The fragments of a pixel, the nearest first.
    pub(super) fn of(&self, pixel: usize) -> &[Fragment] {
        let start = pixel.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.fragments[start..self.ends[pixel]]
    }

    /// The exact share of the light that reaches the eye from a distance along the ray of a
    /// pixel.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn share(&self, pixel: usize, distance: f32) -> f32 {
        let before = self.of(pixel).iter();
        let before = before.take_while(|fragment| fragment.distance < distance);
        before.map(|fragment| 1.0 - fragment.alpha).product()
    }

    /// What the hair lets through of everything behind it: a curve of up to 16 nodes per pixel.
    pub fn cover(&self, cpu: &Cpu) -> Cover {
        Cover::new(cpu.map(self.ends.len(), |pixel| steps(self.of(pixel))))
    }
}

/// The steps of the curve of a pixel.
fn steps(fragments: &[Fragment]) -> Vec<CoverStep> {
    if fragments.is_empty() {
        return Vec::new();
    }
    let mut curve = Nodes::new();
    for fragment in fragments {
        // This cannot fail: distances are finite, and shares are from 0 to 1.
        if let Ok(surface) = BlockerSegment::surface(fragment.distance, 1.0 - fragment.alpha) {
            curve.insert(&surface);
        }
    }
    let curve = curve.finish();
    let mut last = (0.0, 1.0);
    let mut steps = Vec::new();
    for (distance, [share]) in curve.points() {
        // Where the curve has dropped nodes it falls linearly; a step stands in its middle.
        if share < last.1 {
            steps.push(CoverStep {
                distance: 0.5 * (last.0 + distance),
                share,
            });
        }
        last = (distance, share);
    }
    steps
}

/// All strands in the picture.
struct Layers<'a> {
    picture: Picture,
    translucent: &'a [Translucent],
    layers: Vec<(u32, &'a Strands, Bins)>,
    view: &'a View,
}

/// The part of one pixel that one piece covers.
struct Part {
    pixel: usize,
    caster: u32,
    piece: u32,
    covered: Covered,
    opacity: f64,
}

/// The fragments of one unit of work.
struct OfTile {
    ends: Vec<usize>,
    fragments: Vec<Fragment>,
}

impl OfTile {
    fn of(&self, pixel: usize) -> &[Fragment] {
        let start = pixel.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.fragments[start..self.ends[pixel]]
    }
}

impl Layers<'_> {
    fn of_tile(&self, tile: &Tile) -> OfTile {
        let mut parts = Vec::new();
        for (caster, strands, bins) in &self.layers {
            for piece in bins.of_tile(tile) {
                let axis = strands.piece(piece as usize);
                let Some(outline) = Outline::new(&self.picture, &axis) else {
                    continue;
                };
                let texels = outline.texels(&self.picture);
                let Some(texels) = texels.and_then(|texels| texels.within(tile)) else {
                    continue;
                };
                outline.covered(texels, |[x, y], covered| {
                    parts.push(Part {
                        pixel: (y as usize - tile.y.start) * SIDE + x as usize - tile.x.start,
                        caster: *caster,
                        piece,
                        covered,
                        opacity: axis.opacity.into(),
                    });
                });
            }
        }
        parts.sort_unstable_by_key(|part| (part.pixel, part.caster, part.piece));
        let mut tile_of = OfTile {
            ends: Vec::with_capacity(SIDE * SIDE),
            fragments: Vec::new(),
        };
        let mut own = Vec::new();
        let mut parts = &parts[..];
        for pixel in 0..SIDE * SIDE {
            let count = parts.partition_point(|part| part.pixel <= pixel);
            let (of_pixel, others) = parts.split_at(count);
            parts = others;
            own.clear();
            own.extend(
                of_pixel
                    .chunk_by(|a, b| self.are_joined(a, b))
                    .map(fragment),
            );
            let (x, y) = (tile.x.start + pixel % SIDE, tile.y.start + pixel / SIDE);
            if !own.is_empty() {
                let ray = &self.view.rays()[y * self.view.width() as usize + x];
                own.retain(|fragment| fragment.distance < ray.length());
                own.sort_unstable_by(|a, b| self.order(a, b));
                let mut left = 1.0;
                let last = own.iter().position(|fragment| {
                    left *= 1.0 - fragment.alpha;
                    left < HIDDEN
                });
                own.truncate(last.map_or(own.len(), |last| last + 1));
            }
            tile_of.fragments.extend(&own);
            tile_of.ends.push(tile_of.fragments.len());
        }
        tile_of
    }

    fn strands(&self, caster: u32) -> &Strands {
        match &self.translucent[caster as usize] {
            Translucent::Strands(strands) => strands,
            _ => unreachable!("fragments are of strands"),
        }
    }

    /// Whether the second part belongs to the piece that follows the piece of the first.
    fn are_joined(&self, a: &Part, b: &Part) -> bool {
        a.caster == b.caster
            && a.piece + 1 == b.piece
            && !self.strands(a.caster).is_last_piece(a.piece as usize)
    }

    /// By distance; where that is equal, by values that do not depend on the order of the
    /// strands.
    fn order(&self, a: &Fragment, b: &Fragment) -> Ordering {
        let near = a.distance.total_cmp(&b.distance);
        near.then(a.alpha.total_cmp(&b.alpha)).then_with(|| {
            let key = |fragment: &Fragment| {
                let strands = self.strands(fragment.caster);
                let (piece, share) = (fragment.piece as usize, fragment.share);
                let Piece { axis, .. } = strands.piece(piece);
                let colour = strands.colour(piece, share);
                [axis[0], axis[1], colour].map(|v| v.to_array().map(f32::to_bits))
            };
            key(a).cmp(&key(b))
        })
    }
}

/// The fragment of joined pieces in a pixel.
fn fragment(parts: &[Part]) -> Fragment {
    let (mut covered, mut kept, mut distance) = (0.0, 0.0, 0.0);
    let mut largest = &parts[0];
    for part in parts {
        let coverage = part.covered.coverage;
        covered += coverage;
        kept += coverage * part.opacity;
        distance += coverage * part.covered.distance;
        if coverage > largest.covered.coverage {
            largest = part;
        }
    }
    Fragment {
        distance: (distance / covered) as f32,
        // On the inside of a bend pieces overlap, and their areas add up to more than the
        // pixel.
        alpha: (kept / f64::max(covered, 1.0)) as f32,
        caster: largest.caster,
        piece: largest.piece,
        share: largest.covered.share as f32,
    }
}
