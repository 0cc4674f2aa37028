//! Closed scenes under a slanted sun: a city and a fractal landscape.

use glam::dcamera::rh::view::look_at_mat4;
use glam::{DMat4, DVec3};
use gpu_backend::Cpu;
use reference::random::noise;
use shadow_dag::{DepthSource, Error, Exits, LightSpace, Mesh, Resolution, Surfaces, TileRect};

/// The sun over ground that spans 0…1 along x and y; no face is parallel to
/// an axis of its space.
pub(crate) fn sun() -> Result<LightSpace, Error> {
    let middle = DVec3::new(0.5, 0.5, 0.0);
    let view: DMat4 = look_at_mat4(middle + DVec3::new(0.2, -0.54, 0.82), middle, DVec3::Y);
    LightSpace::orthographic(view, 1.4, 1.4, 0.3, 1.7)
}

#[derive(Debug, Default)]
struct Triangles {
    positions: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
}

impl Triangles {
    /// A box that stands upright, turned about its axis.
    fn block(&mut self, middle: [f32; 2], half: [f32; 2], angle: f32, bottom: f32, top: f32) {
        let first = self.positions.len() as u32;
        let (s, c) = angle.sin_cos();
        for corner in 0..8 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let (x, y) = (half[0] * sign(0), half[1] * sign(1));
            let z = if corner >> 2 == 1 { top } else { bottom };
            let at = [middle[0] + c * x - s * y, middle[1] + s * x + c * y, z];
            self.positions.push(at);
        }
        for [a, b, c, d] in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            self.indices.push([first + a, first + b, first + c]);
            self.indices.push([first + a, first + c, first + d]);
        }
    }

    fn mesh(&self, resolution: Resolution) -> Result<Mesh, Error> {
        Mesh::new(resolution, sun()?, &self.positions, &self.indices)
    }
}

/// Buildings of a few storeys with things on their roofs, on a slab of
/// ground; `streets²` of them.
pub(crate) fn city(resolution: Resolution, streets: u32, things: u32) -> Result<Mesh, Error> {
    buildings(streets, things).mesh(resolution)
}

/// The same with a car on its way through a street, which is at 0…1.
pub(crate) fn traffic(resolution: Resolution, streets: u32, at: f32) -> Result<Mesh, Error> {
    let mut scene = buildings(streets, 2);
    let pitch = 1.0 / streets as f32;
    let middle = [at, (streets / 2) as f32 * pitch];
    scene.block(
        middle,
        [0.04 * pitch, 0.02 * pitch],
        0.0,
        0.001 * pitch,
        0.04 * pitch,
    );
    scene.mesh(resolution)
}

fn buildings(streets: u32, things: u32) -> Triangles {
    let mut scene = Triangles::default();
    let mut seed = 0;
    let mut next = || {
        seed += 1;
        noise(seed)
    };
    let pitch = 1.0 / streets as f32;
    for building in 0..streets * streets {
        let middle = [building % streets, building / streets].map(|i| (i as f32 + 0.5) * pitch);
        let mut half = [0, 1].map(|_| pitch * (0.2 + 0.15 * next()));
        let mut bottom = 0.0;
        for storey in 0..1 + (3.0 * next()) as u32 {
            let top = bottom + pitch * (0.3 + 1.5 * next()) / (1 + storey) as f32;
            scene.block(middle, half, 0.3, bottom, top);
            half = half.map(|half| half * (0.5 + 0.4 * next()));
            bottom = top;
            for _ in 0..things {
                let place = [0, 1].map(|i| middle[i] + 0.6 * half[i] * (2.0 * next() - 1.0));
                let size = [0, 1].map(|_| pitch * (0.01 + 0.04 * next()));
                scene.block(
                    place,
                    size,
                    0.3,
                    top - 0.01 * pitch,
                    top + 0.1 * pitch * next(),
                );
            }
        }
    }
    scene.block([0.5; 2], [0.5; 2], 0.0, -0.05, 0.0);
    scene
}

/// Sixteen posts on a floor of two triangles, under a sun and under a lamp.
pub(crate) fn posts(resolution: Resolution) -> Result<[Mesh; 2], Error> {
    let mut scene = Triangles::default();
    for post in 0..16 {
        let at = [post % 4, post / 4].map(|i| 0.2 + 0.2 * i as f32);
        scene.block(at, [0.004; 2], 0.3, 0.0, 0.1);
    }
    let first = scene.positions.len() as u32;
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        scene.positions.push([x, y, 0.0]);
    }
    let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + corner);
    scene.indices.extend([[a, b, c], [a, c, d]]);
    let middle = DVec3::new(0.5, 0.5, 0.0);
    let view: DMat4 = look_at_mat4(middle + DVec3::new(0.1, -0.2, 0.5), middle, DVec3::Y);
    let lamp = LightSpace::perspective(view, 2.0, 0.1, 2.0)?;
    let surfaces = Surfaces::new(&scene.positions[..], &scene.indices[..])?;
    Ok([sun()?, lamp].map(|light| surfaces.seen_from(light, resolution)))
}

/// [`hills`] under a sun.
pub(crate) fn landscape(resolution: Resolution, cells: u32) -> Result<Mesh, Error> {
    let (positions, indices) = hills(cells);
    Triangles { positions, indices }.mesh(resolution)
}

/// Fractal noise over a plane, closed underneath, of `4 · cells · (cells + 2)`
/// triangles.
pub(crate) fn hills(cells: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut scene = Triangles::default();
    let corner =
        |x: u32, y: u32, octave: u64| noise(octave << 48 ^ u64::from(x) << 24 ^ u64::from(y)) - 0.5;
    let height = |u: f32, v: f32| -> f32 {
        (0..8)
            .map(|octave| {
                let scale = (5 << octave) as f32;
                let (x, y) = ((u * scale).floor(), (v * scale).floor());
                let (fx, fy) = (u * scale - x, v * scale - y);
                let at = |dx: u32, dy: u32| corner(x as u32 + dx, y as u32 + dy, octave);
                let row = |dy: u32| at(0, dy) * (1.0 - fx) + at(1, dy) * fx;
                (row(0) * (1.0 - fy) + row(1) * fy) * 0.2 / (1 << octave) as f32
            })
            .sum()
    };
    let width = cells + 1;
    for side in 0..2 {
        for i in 0..width * width {
            let (u, v) = (
                (i % width) as f32 / cells as f32,
                (i / width) as f32 / cells as f32,
            );
            let z = if side == 0 { height(u, v) } else { -0.2 };
            scene.positions.push([u, v, z]);
        }
    }
    let under = width * width;
    for y in 0..cells {
        for x in 0..cells {
            let a = y * width + x;
            let [b, c, d] = [a + 1, a + width + 1, a + width];
            scene.indices.extend([[a, b, c], [a, c, d]]);
            let [a, b, c, d] = [a, b, c, d].map(|corner| corner + under);
            scene.indices.extend([[a, c, b], [a, d, c]]);
        }
    }
    for i in 0..cells {
        let last = cells * width;
        for (a, b) in [
            (i, i + 1),
            (i * width + cells, (i + 1) * width + cells),
            (last + i + 1, last + i),
            ((i + 1) * width, i * width),
        ] {
            scene
                .indices
                .extend([[a, a + under, b + under], [a, b + under, b]]);
        }
    }
    (scene.positions, scene.indices)
}

/// Enter and exit slices in memory.
pub(crate) struct Maps {
    resolution: Resolution,
    enter: Vec<u32>,
    exit: Vec<u32>,
    pub(crate) open: bool,
}

impl Maps {
    pub(crate) fn of(mesh: &Mesh) -> Result<Self, Error> {
        let n = mesh.resolution().side();
        let side = n.min(1024);
        let across = n / side;
        let tiles = Cpu::new().map((across * across) as usize, |i| {
            let (x, y) = (i as u32 % across * side, i as u32 / across * side);
            let tile = TileRect { x, y, side };
            let (mut enter, mut exit) = (vec![0; tile.len()], vec![0; tile.len()]);
            mesh.read(tile, &mut enter, &mut exit)?;
            Ok::<_, Error>((tile, enter, exit))
        });
        let texels = (n as usize).pow(2);
        let mut maps = Self {
            resolution: mesh.resolution(),
            enter: vec![0; texels],
            exit: vec![0; texels],
            open: false,
        };
        for tile in tiles {
            let (tile, enter, exit) = tile?;
            let side = side as usize;
            for row in 0..side {
                let to = (tile.y as usize + row) * n as usize + tile.x as usize;
                maps.enter[to..to + side].copy_from_slice(&enter[row * side..][..side]);
                maps.exit[to..to + side].copy_from_slice(&exit[row * side..][..side]);
            }
        }
        Ok(maps)
    }

    /// Edges between texels whose intervals are disjoint.
    pub(crate) fn silhouette_edges(&self) -> usize {
        let n = self.resolution.side() as usize;
        let apart =
            |a: usize, b: usize| self.enter[a].max(self.enter[b]) > self.exit[a].min(self.exit[b]);
        (0..n * n)
            .map(|i| {
                usize::from(i % n + 1 < n && apart(i, i + 1))
                    + usize::from(i + n < n * n && apart(i, i + n))
            })
            .sum()
    }

    pub(crate) fn enter(&self, x: u32, y: u32) -> u32 {
        self.enter[y as usize * self.resolution.side() as usize + x as usize]
    }

    /// The lit share of a window of a shadow map, texel by texel.
    pub(crate) fn filter(&self, x: i32, y: i32, z: i32, half: i32) -> f32 {
        let n = self.resolution.side() as i32;
        let (x, y) = (x.clamp(half, n - 1 - half), y.clamp(half, n - 1 - half));
        let width = (2 * half + 1) as usize;
        let mut lit = 0;
        for y in y - half..=y + half {
            let row = y as usize * n as usize + (x - half) as usize;
            lit += self.enter[row..row + width]
                .iter()
                .map(|&enter| u32::from((z as u32) < enter))
                .sum::<u32>();
        }
        lit as f32 / (width * width) as f32
    }
}

impl DepthSource for Maps {
    fn resolution(&self) -> Resolution {
        self.resolution
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        let (n, side) = (self.resolution.side() as usize, tile.side as usize);
        for row in 0..side {
            let from = (tile.y as usize + row) * n + tile.x as usize;
            enter[row * side..][..side].copy_from_slice(&self.enter[from..][..side]);
            if !self.open {
                exit[row * side..][..side].copy_from_slice(&self.exit[from..][..side]);
            }
        }
        Ok(if self.open {
            Exits::Open
        } else {
            Exits::Closed
        })
    }
}
