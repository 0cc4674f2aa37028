//! Baked shadows by themselves: what they take to bake and to hold, and what a
//! question costs.

use std::fmt::Write;
use std::time::Instant;

use glam::{DVec3, Vec3};
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{
    Builder, FilterSize, Form, Resolution, Watertightness, light_spaces, surfaces,
};
use lighting::scene::{Camera, Geometry};
use lighting::trace::Tracer;
use lighting::view::View;
use shadow_dag::{DepthSource, Error, Exits, LightSpace, Mesh, Rule, ShadowDag, TileRect};

use super::results::Times;
use crate::failure::Failure;
use crate::parse::Size;
use crate::progress;

/// Everything that the section says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Dag {
    /// The light in words; empty if there is nothing to say.
    pub(crate) light: String,
    pub(crate) watertightness: Watertightness,
    pub(crate) sizes: Option<Sizes>,
    pub(crate) bakes: Vec<Bake>,
    pub(crate) filters: Option<Filters>,
    /// What there was no time for.
    pub(crate) left_out: Vec<&'static str>,
}

/// What rules and forms take, on the same map.
#[derive(Debug, Clone)]
pub(crate) struct Sizes {
    pub(crate) resolution: u32,
    /// Edges between texels whose depths have nothing in common.
    pub(crate) edges: u64,
    pub(crate) rows: Vec<SizeRow>,
}

/// One rule.
#[derive(Debug, Clone)]
pub(crate) struct SizeRow {
    pub(crate) rule: &'static str,
    /// Bytes of the plain and of the packed file.
    pub(crate) bytes: [u64; 2],
    /// Seconds to build from maps in memory, with and without culling.
    pub(crate) seconds: [f64; 2],
}

/// One whole bake, from triangles to a packed file.
#[derive(Debug, Clone)]
pub(crate) struct Bake {
    pub(crate) resolution: u32,
    /// Seconds and peak memory of each of [`STAGES`]; memory where the system
    /// tells.
    pub(crate) stages: [(f64, Option<u64>); 4],
    pub(crate) bytes: u64,
}

impl Bake {
    pub(crate) fn seconds(&self) -> f64 {
        self.stages.iter().map(|stage| stage.0).sum()
    }
}

/// What a bake does one after the other.
pub(crate) const STAGES: [&str; 4] = ["sort triangles", "tiles", "put together", "pack"];

/// Shadows on the surfaces of one picture.
#[derive(Debug, Clone)]
pub(crate) struct Filters {
    pub(crate) size: Size,
    pub(crate) resolution: u32,
    /// Surfaces within the grid that face the light.
    pub(crate) receivers: usize,
    /// Frame times by width of the filter: plain, packed.
    pub(crate) rows: Vec<(u32, [Times; 2])>,
}

/// What is asked for.
struct Extent {
    sizes: u32,
    bakes: [u32; 2],
    filters: u32,
    picture: Size,
}

const QUICK: Extent = Extent {
    sizes: 512,
    bakes: [1 << 11, 1 << 13],
    filters: 1024,
    picture: Size {
        width: 320,
        height: 180,
    },
};
const ALL: Extent = Extent {
    sizes: 2048,
    bakes: [1 << 11, 1 << 18],
    filters: 8192,
    picture: Size {
        width: 1920,
        height: 1080,
    },
};

/// Widths of filters on surfaces.
const WIDTHS: [u32; 3] = [1, 3, 9];

/// Bakes the first light whose shadows one grid can hold, or the fullest grid
/// of the first light. Nothing is begun that would end long after `seconds`.
pub(crate) fn judge(
    (geometry, tracer, camera): (&Geometry, &Tracer, &Camera),
    emitters: &[Emitter],
    quick: bool,
    seconds: f64,
) -> Result<Dag, Failure> {
    let extent = if quick { QUICK } else { ALL };
    let clock = Instant::now();
    if emitters.is_empty() {
        return Ok(Dag::default());
    }
    let is_over = || clock.elapsed().as_secs_f64() >= seconds;
    let Some((emitter, light, grid)) = suitable(geometry, emitters, is_over)? else {
        return Ok(Dag {
            left_out: vec!["baked shadows"],
            ..Dag::default()
        });
    };
    let space = |side: u32| -> Result<(LightSpace, Resolution), Failure> {
        let resolution = Resolution::new(side)?;
        let mut spaces = light_spaces(geometry, emitter, resolution)?;
        Ok((spaces.swap_remove(grid), resolution))
    };
    let bar = progress::bar("baked shadows", 3);
    let mut dag = Dag {
        light,
        ..Dag::default()
    };
    let (light, resolution) = space(extent.sizes)?;
    let mesh = surfaces(geometry)?.seen_from(light, resolution);
    dag.watertightness = mesh.watertightness();
    // A scene of millions of triangles leaves no time for tables.
    let sorted = clock.elapsed().as_secs_f64();
    if sorted < 0.15 * seconds {
        dag.sizes = Some(sizes(&mesh)?);
    } else {
        dag.left_out.push("rules and forms of baked shadows");
    }
    bar.inc(1);
    if clock.elapsed().as_secs_f64() + sorted < 0.4 * seconds {
        let (light, resolution) = space(extent.filters)?;
        let plain = Builder::new().bake(
            &Cpu::new(),
            &surfaces(geometry)?.seen_from(light, resolution),
        )?;
        dag.filters = Some(filters(
            &plain,
            (geometry, tracer, camera),
            emitter,
            &extent,
        )?);
    } else {
        dag.left_out.push("filters of baked shadows");
    }
    bar.inc(1);
    let mut side = extent.bakes[0];
    let mut last = sorted;
    while side <= extent.bakes[1] && clock.elapsed().as_secs_f64() + 2.5 * last < seconds {
        let (light, resolution) = space(side)?;
        let bake = bake(geometry, light, resolution)?;
        last = bake.seconds();
        dag.bakes.push(bake);
        side *= 2;
    }
    if side <= extent.bakes[1] {
        dag.left_out.push("bakes at higher resolutions");
    }
    bar.finish_and_clear();
    Ok(dag)
}

/// The light to be baked: in words, and the number of the grid. None if there is
/// no light, or the time is over before it is found, as it may be in a scene of
/// many triangles.
fn suitable<'a>(
    geometry: &Geometry,
    emitters: &'a [Emitter],
    mut is_over: impl FnMut() -> bool,
) -> Result<Option<(&'a Emitter, String, usize)>, Failure> {
    let coarse = Resolution::new(64)?;
    let name = |emitter: &Emitter| match emitter {
        Emitter::Directional(_) => "the sun",
        _ => "a light at a point",
    };
    let mut fullest = None;
    for emitter in emitters {
        if is_over() {
            return Ok(None);
        }
        let spaces = light_spaces(geometry, emitter, coarse)?;
        if let [_] = spaces[..] {
            return Ok(Some((emitter, name(emitter).into(), 0)));
        }
        if fullest.is_some() {
            continue;
        }
        let mut most = (0, 0);
        for (grid, space) in spaces.into_iter().enumerate() {
            let mesh = surfaces(geometry)?.seen_from(space, coarse);
            let bytes = Builder::new().bake(&Cpu::new(), &mesh)?.as_bytes().len();
            most = most.max((bytes, grid));
            if is_over() {
                return Ok(None);
            }
        }
        let name = format!("{}, the fullest of its six grids", name(emitter));
        fullest = Some((emitter, name, most.1));
    }
    Ok(fullest)
}

/// Depths of a whole map in memory.
struct Maps {
    resolution: Resolution,
    light: Option<LightSpace>,
    enter: Vec<u32>,
    exit: Vec<u32>,
}

/// Texels along each side of the tiles in which a map is made.
const TILE: u32 = 256;

impl Maps {
    fn of(mesh: &Mesh) -> Result<Self, Error> {
        let resolution = mesh.resolution();
        let side = resolution.side();
        let width = side / TILE;
        let tile = |index: usize| TileRect {
            x: index as u32 % width * TILE,
            y: index as u32 / width * TILE,
            side: TILE,
        };
        let tiles = Cpu::new().map((width * width) as usize, |index| {
            let (mut enter, mut exit) = (vec![0; tile(index).len()], vec![0; tile(index).len()]);
            mesh.read(tile(index), &mut enter, &mut exit)
                .map(|_| (enter, exit))
        });
        let texels = (side as usize).pow(2);
        let mut maps = Self {
            resolution,
            light: mesh.light(),
            enter: vec![0; texels],
            exit: vec![0; texels],
        };
        for (index, depths) in tiles.into_iter().enumerate() {
            let (enter, exit) = depths?;
            for (row, (enter, exit)) in
                (0..).zip(enter.chunks(TILE as usize).zip(exit.chunks(TILE as usize)))
            {
                let at = maps.at(tile(index).x, tile(index).y + row);
                maps.enter[at..at + enter.len()].copy_from_slice(enter);
                maps.exit[at..at + exit.len()].copy_from_slice(exit);
            }
        }
        Ok(maps)
    }

    fn at(&self, x: u32, y: u32) -> usize {
        y as usize * self.resolution.side() as usize + x as usize
    }

    /// Edges between texels whose depths have nothing in common.
    fn silhouette_edges(&self) -> u64 {
        let side = self.resolution.side() as usize;
        let apart = |a: usize, b: usize| {
            u64::from(self.enter[a].max(self.enter[b]) > self.exit[a].min(self.exit[b]))
        };
        let mut edges = 0;
        for at in 0..side * side {
            if at % side + 1 < side {
                edges += apart(at, at + 1);
            }
            if at + side < side * side {
                edges += apart(at, at + side);
            }
        }
        edges
    }
}

impl DepthSource for Maps {
    fn resolution(&self) -> Resolution {
        self.resolution
    }

    fn light(&self) -> Option<LightSpace> {
        self.light
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        let side = tile.side as usize;
        for (row, (enter, exit)) in
            (tile.y..).zip(enter.chunks_mut(side).zip(exit.chunks_mut(side)))
        {
            let at = self.at(tile.x, row);
            enter.copy_from_slice(&self.enter[at..at + side]);
            exit.copy_from_slice(&self.exit[at..at + side]);
        }
        Ok(Exits::Closed)
    }
}

fn sizes(mesh: &Mesh) -> Result<Sizes, Failure> {
    let maps = Maps::of(mesh)?;
    let cpu = Cpu::new();
    let mut rows = Vec::new();
    for (name, rule) in [
        ("2014", Rule::Sintorn2014),
        ("2015", Rule::Kampe2015),
        ("aligned", Rule::Aligned),
    ] {
        let builder = Builder::new().rule(rule);
        let clock = Instant::now();
        builder.culling(false).build(&cpu, &maps)?;
        let unculled = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let plain = builder.build(&cpu, &maps)?;
        let culled = clock.elapsed().as_secs_f64();
        let packed = plain.to_form(Form::Packed)?;
        rows.push(SizeRow {
            rule: name,
            bytes: [plain, packed].map(|dag| dag.as_bytes().len() as u64),
            seconds: [culled, unculled],
        });
    }
    Ok(Sizes {
        resolution: mesh.resolution().side(),
        edges: maps.silhouette_edges(),
        rows,
    })
}

fn bake(geometry: &Geometry, light: LightSpace, resolution: Resolution) -> Result<Bake, Failure> {
    let cpu = Cpu::new();
    let never = std::sync::atomic::AtomicBool::new(false);
    let mut stage = Stage::begin();
    let mesh = surfaces(geometry)?.seen_from(light, resolution);
    let sorted = stage.next();
    let mut bake = shadow_dag::Bake::of_mesh(Builder::new(), &mesh);
    bake.advance(&cpu, usize::MAX, &never, |_| {})?;
    let made = stage.next();
    let plain = bake.finish()?;
    let joined = stage.next();
    let bytes = plain.to_form(Form::Packed)?.as_bytes().len() as u64;
    Ok(Bake {
        resolution: resolution.side(),
        stages: [sorted, made, joined, stage.next()],
        bytes,
    })
}

/// Time and memory of one stage after the other.
struct Stage(Instant);

impl Stage {
    fn begin() -> Self {
        forget_peak();
        Self(Instant::now())
    }

    /// What the stage took that ends now.
    fn next(&mut self) -> (f64, Option<u64>) {
        let stage = (self.0.elapsed().as_secs_f64(), peak());
        forget_peak();
        self.0 = Instant::now();
        stage
    }
}

/// The most memory of the process since [`forget_peak`], bytes; Linux tells.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Begins to look for the most memory anew, where the system can.
fn forget_peak() {
    // Peaks of earlier work are counted where it cannot.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Runs of one filter over a picture, and the most time they take together.
const RUNS: usize = 5;
const SECONDS: f64 = 0.6;

/// Positions and normals in the grid of what faces the light within its map.
///
/// What lies beside the map is the business of another grid, or lit: nothing is
/// looked up there.
fn receivers(
    dag: &ShadowDag,
    (geometry, view): (&Geometry, &View),
    emitter: &Emitter,
) -> Vec<(DVec3, Vec3)> {
    let resolution = dag.resolution();
    let side = f64::from(resolution.side());
    let surfaces = view.rays().iter().zip(view.hits());
    surfaces
        .filter_map(|(ray, hit)| {
            let hit = hit.as_ref()?;
            let [a, b, c] = geometry.triangles()[hit.triangle as usize];
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let point = ray.at(hit.distance);
            let to_light = match emitter {
                Emitter::Directional(sun) => -sun.direction(),
                Emitter::Point(light) => light.position() - point,
                _ => return None,
            };
            let space = dag.light()?;
            let position = space.voxel(resolution, point)?;
            let is_within = [position.x, position.y]
                .iter()
                .all(|at| (0.0..side).contains(at))
                && position.z >= 0.0;
            (is_within && normal.dot(to_light) > 0.0)
                .then(|| (position, space.normal(point, normal)))
        })
        .collect()
}

fn filters(
    plain: &ShadowDag,
    (geometry, tracer, camera): (&Geometry, &Tracer, &Camera),
    emitter: &Emitter,
    extent: &Extent,
) -> Result<Filters, Failure> {
    let cpu = Cpu::new();
    let Size { width, height } = extent.picture;
    let view = View::new(&cpu, camera, tracer, width, height)?;
    let packed = plain.to_form(Form::Packed)?;
    let resolution = plain.resolution();
    let receivers = receivers(plain, (geometry, &view), emitter);
    let mut rows = Vec::new();
    for width in WIDTHS {
        let size = FilterSize::new(width)?;
        let biased = receivers.iter().map(|(at, normal)| size.bias(*at, *normal));
        let voxels: Vec<_> = biased.collect();
        let mut lit = vec![0.0; voxels.len()];
        let mut time = |dag: &ShadowDag| -> Result<Times, Failure> {
            let mut seconds = Vec::new();
            while seconds.len() < RUNS && seconds.iter().sum::<f64>() < SECONDS {
                let clock = Instant::now();
                dag.filter_batch(&cpu, &voxels, size, &mut lit)?;
                seconds.push(clock.elapsed().as_secs_f64());
            }
            Ok(Times::of(&seconds))
        };
        rows.push((width, [time(plain)?, time(&packed)?]));
    }
    Ok(Filters {
        size: extent.picture,
        resolution: resolution.side(),
        receivers: receivers.len(),
        rows,
    })
}

/// `shadows.csv`: one number per line.
pub(crate) fn csv(dag: &Dag) -> String {
    let mut out = "what,setting,voxels,unit,value\n".to_owned();
    // Writing to a string cannot fail.
    let mut line = |what: &str, setting: &str, voxels: u32, unit: &str, value: f64| {
        let _ = writeln!(out, "{what},{setting},{voxels},{unit},{value:e}");
    };
    if let Some(sizes) = &dag.sizes {
        line(
            "silhouette",
            "",
            sizes.resolution,
            "edges",
            sizes.edges as f64,
        );
        for row in &sizes.rows {
            let [plain, packed] = row.bytes.map(|bytes| bytes as f64);
            line("size plain", row.rule, sizes.resolution, "bytes", plain);
            line("size packed", row.rule, sizes.resolution, "bytes", packed);
            let [culled, unculled] = row.seconds;
            line("build", row.rule, sizes.resolution, "seconds", culled);
            line(
                "build without culling",
                row.rule,
                sizes.resolution,
                "seconds",
                unculled,
            );
        }
    }
    for bake in &dag.bakes {
        for (name, (seconds, peak)) in STAGES.iter().zip(bake.stages) {
            line("bake", name, bake.resolution, "seconds", seconds);
            if let Some(peak) = peak {
                line("bake", name, bake.resolution, "bytes", peak as f64);
            }
        }
        line(
            "file packed",
            "",
            bake.resolution,
            "bytes",
            bake.bytes as f64,
        );
    }
    if let Some(filters) = &dag.filters {
        for (width, times) in &filters.rows {
            for (form, time) in ["plain", "packed"].iter().zip(times) {
                let setting = format!("{width}x{width} {form}");
                line(
                    "filter",
                    &setting,
                    filters.resolution,
                    "seconds",
                    time.median,
                );
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use lighting::procedural::Embedded;

    use super::*;

    #[test]
    fn every_part_of_a_scene_is_judged_and_rules_get_better_over_the_years() {
        for embedded in [Embedded::City, Embedded::Coil] {
            let mut scene = embedded.build(1);
            let geometry = Geometry::new(&scene).unwrap();
            scene.complete(geometry.bounds()).unwrap();
            let (tracer, camera) = (Tracer::new(&geometry), scene.camera.unwrap());
            let emitters = scene.lights[0].emitters(1).unwrap();
            let dag = judge((&geometry, &tracer, &camera), &emitters, true, 60.0).unwrap();
            let sizes = dag.sizes.as_ref().unwrap();
            assert!(sizes.edges > 100, "{}", sizes.edges);
            for pair in sizes.rows.windows(2) {
                assert!(pair[1].bytes[1] <= pair[0].bytes[1], "{sizes:?}");
            }
            let filters = dag.filters.as_ref().unwrap();
            assert!(filters.receivers > 1000 && filters.rows.len() == WIDTHS.len());
            assert!(!dag.light.is_empty());
            for line in csv(&dag).lines().skip(1) {
                let columns: Vec<&str> = line.split(',').collect();
                assert_eq!(columns.len(), 5, "{line}");
                assert!(columns[4].parse::<f64>().unwrap() > 0.0, "{line}");
            }
        }
        let geometry = Geometry::new(&Embedded::City.build(1)).unwrap();
        let camera = Camera::look_at(glam::Vec3::ZERO, glam::Vec3::X, 1.0).unwrap();
        let nothing = (&geometry, &Tracer::new(&geometry), &camera);
        assert!(judge(nothing, &[], true, 60.0).unwrap().light.is_empty());
    }

    #[test]
    fn nothing_is_begun_when_the_time_is_over() {
        let mut scene = Embedded::Coil.build(1);
        let geometry = Geometry::new(&scene).unwrap();
        scene.complete(geometry.bounds()).unwrap();
        let (tracer, camera) = (Tracer::new(&geometry), scene.camera.unwrap());
        let emitters = scene.lights[0].emitters(1).unwrap();
        let parts = (&geometry, &tracer, &camera);
        let dag = judge(parts, &emitters, true, 0.0).unwrap();
        assert_eq!(dag.left_out, ["baked shadows"]);
        assert!(dag.light.is_empty() && dag.bakes.is_empty());
        // The clock is looked at before the light and after each of its grids.
        for most in 0..7 {
            let mut looks = 0;
            let is_over = || {
                looks += 1;
                looks > most
            };
            let found = suitable(&geometry, &emitters[..1], is_over).unwrap();
            assert!(found.is_none() && looks == most + 1, "{most} {looks}");
        }
        let found = suitable(&geometry, &emitters[..1], || false).unwrap();
        assert!(found.is_some());
    }

    #[test]
    fn receivers_are_surfaces_within_the_grid() {
        let mut scene = Embedded::Coil.build(1);
        let geometry = Geometry::new(&scene).unwrap();
        scene.complete(geometry.bounds()).unwrap();
        let (tracer, camera) = (Tracer::new(&geometry), scene.camera.unwrap());
        let emitter = &scene.lights[0].emitters(1).unwrap()[0];
        let (cpu, resolution) = (Cpu::new(), Resolution::new(64).unwrap());
        let view = View::new(&cpu, &camera, &tracer, 160, 90).unwrap();
        let spaces = light_spaces(&geometry, emitter, resolution).unwrap();
        assert_eq!(spaces.len(), 6);
        let mut all = 0;
        for space in spaces {
            let mesh = surfaces(&geometry).unwrap().seen_from(space, resolution);
            let dag = Builder::new().bake(&cpu, &mesh).unwrap();
            let found = receivers(&dag, (&geometry, &view), emitter);
            for (at, _) in &found {
                let on_map = at.min_element() >= 0.0 && at.x.max(at.y) < 64.0;
                assert!(on_map, "{at}");
            }
            all += found.len();
        }
        // Each is in one of the grids, but on their rims.
        let seen = view.hits().iter().flatten().count();
        assert!(all > 0 && all <= seen, "{all} of {seen}");
    }

    #[test]
    fn silhouettes_are_where_depths_have_nothing_in_common() {
        let side = 256_usize;
        let column = |i: usize| u32::from(i % side >= 100);
        // A step from [0, 10] to [20, 30] along a column, and one that overlaps.
        let maps = Maps {
            resolution: Resolution::new(256).unwrap(),
            light: None,
            enter: (0..side * side).map(|i| 20 * column(i)).collect(),
            exit: (0..side * side)
                .map(|i| 10 + 20 * column(i) + u32::from(i >= side * side / 2) * 10)
                .collect(),
        };
        assert_eq!(maps.silhouette_edges(), 128);
    }
}
