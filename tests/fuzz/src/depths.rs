//! Depth maps, the graphs made of them, and questions to those.

use glam::IVec3;
use gpu_backend::Cpu;
use shadow_dag::{
    Builder, DepthMap, FilterSize, Form, Ray, Resolution, Rule, ShadowDag, Slices, Visibility,
};

use super::Bytes;

/// Depths of a map, block by block: the ends of the range, the planes between slices, any.
fn depths(bytes: &mut Bytes<'_>, side: u32) -> Vec<f32> {
    let mut depths = vec![bytes.one_of(&[f32::INFINITY, 1.0, 0.5, 0.0]); (side * side) as usize];
    for _ in 0..bytes.below(12) {
        let depth = match bytes.byte() {
            0..64 => f32::from(bytes.byte()) / (2 * side) as f32,
            64..96 => bytes.any(),
            96..112 => f32::INFINITY,
            _ => bytes.unit(),
        };
        let [x, y, width, height] = [(); 4].map(|()| bytes.below(side as usize));
        let slope = match bytes.below(2) {
            0 => 0.0,
            _ => bytes.between(-0.2, 0.2),
        };
        let side = side as usize;
        for row in y..(y + height + 1).min(side) {
            for column in x..(x + width + 1).min(side) {
                depths[row * side + column] = depth + slope * (row + column) as f32;
            }
        }
    }
    depths
}

/// Whether a voxel is lit by the map's own depths; `None` inside of a solid, where either
/// is right.
struct Direct<'a> {
    resolution: Resolution,
    slices: Slices,
    enter: &'a [f32],
    exit: Option<&'a [f32]>,
}

impl Direct<'_> {
    fn is_lit(&self, at: IVec3) -> Option<bool> {
        let side = self.resolution.side() as i32;
        if at.z < 0 || at.truncate().min_element() < 0 || at.truncate().max_element() >= side {
            return Some(true);
        }
        let texel = (at.y * side + at.x) as usize;
        let slice = |depths: &[f32]| {
            let depth = f64::from(depths[texel]);
            self.slices.boundary(self.resolution, depth) as i32
        };
        let (enter, z) = (slice(self.enter), at.z.min(side - 1));
        // A surface behind the last slice shadows nothing, however far behind it one asks.
        let exit = self.exit.map_or(enter, |exit| slice(exit).max(enter));
        match (z < enter, z >= exit) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }
}

/// Voxels of the shadows of a map are lit where its depths say so, in either form of the
/// nodes, and what else can be asked agrees with the voxels.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let resolution = Resolution::new(bytes.one_of(&[8, 16, 32])).expect("a power of two");
    let side = resolution.side();
    let rule = bytes.one_of(&[Rule::Aligned, Rule::Kampe2015, Rule::Sintorn2014]);
    let slices = match bytes.below(4) {
        0 => Slices::logarithmic(0.01, 1.0).expect("two distances"),
        _ => Slices::Linear,
    };
    let enter = depths(&mut bytes, side);
    let exit = bytes.flag().then(|| depths(&mut bytes, side));
    let mut map = DepthMap::new(resolution, slices, &enter).expect("a square map");
    if let Some(exit) = &exit {
        map = map.with_exit(exit).expect("a square map");
    }
    let cpu = Cpu::single_threaded();
    let plain = match Builder::new().rule(rule).build(&cpu, &map) {
        Ok(plain) => plain,
        Err(error) => {
            let mut depths = enter.iter().chain(exit.iter().flatten());
            assert!(depths.any(|depth| depth.is_nan()), "{error}");
            return;
        }
    };
    let packed = plain.to_form(Form::Packed).expect("few nodes");
    let direct = Direct {
        resolution,
        slices,
        enter: &enter,
        exit: exit.as_deref(),
    };
    let side = side as i32;
    for z in 0..side {
        for y in 0..side {
            for x in 0..side {
                let at = IVec3::new(x, y, z);
                let lit = plain.is_lit(at);
                assert_eq!(lit, packed.is_lit(at), "{at}");
                let expected = direct.is_lit(at);
                assert!(
                    expected.is_none_or(|expected| lit == expected),
                    "{at}: {lit}"
                );
            }
        }
    }
    for _ in 0..4 {
        ask([&plain, &packed], &mut bytes);
    }
}

/// A filter, a box, a column and a ray, against the voxels in them.
fn ask(dags: [&ShadowDag; 2], bytes: &mut Bytes<'_>) {
    let side = dags[0].resolution().side() as i32;
    let [x, y, z] = [(); 3].map(|()| bytes.below(side as usize + 8) as i32 - 4);
    let at = IVec3::new(x, y, z);
    let size = FilterSize::new(bytes.one_of(&[1, 3, 9, 33])).expect("an odd width");
    let half = size.width() as i32 / 2;
    let around = (-half..=half).flat_map(|dy| (-half..=half).map(move |dx| (dx, dy)));
    let lit = around.filter(|(dx, dy)| dags[0].is_lit(at + IVec3::new(*dx, *dy, 0)));
    let lit = lit.count() as u32;
    let last = at + IVec3::from([(); 3].map(|()| bytes.below(12) as i32));
    let mut seen = [false; 2];
    for z in at.z..=last.z {
        for y in at.y..=last.y {
            for x in at.x..=last.x {
                seen[usize::from(dags[0].is_lit(IVec3::new(x, y, z)))] = true;
            }
        }
    }
    let expected = match seen {
        [true, true] => Visibility::Mixed,
        [true, false] => Visibility::Shadowed,
        _ => Visibility::Lit,
    };
    let texel = [x, y].map(|at| at.clamp(0, side - 1));
    let depth = (0..side).find(|z| !dags[0].is_lit(IVec3::new(texel[0], texel[1], *z)));
    let length = bytes.one_of(&[f32::INFINITY, 0.0, 1.0, 20.0]);
    let ray = Ray::new(at.as_vec3() + bytes.vector(1.0), bytes.direction(), length);
    let ray = ray.expect("finite numbers");
    for dag in dags {
        assert_eq!(dag.count_lit(at, size), lit, "{at}");
        assert_eq!(dag.visibility(at, last), expected, "{at} {last}");
        let column = dag.depth(texel.map(|at| at as u32));
        assert_eq!(column as i32, depth.unwrap_or(side), "{texel:?}");
        let parts = dag.lit_intervals(&ray);
        let in_order = parts.iter().flatten().is_sorted() && parts.iter().all(|[a, b]| a < b);
        assert!(in_order, "{parts:?}");
        let sum: f64 = parts.iter().map(|[start, end]| end - start).sum();
        let found = dag.lit_length(&ray);
        assert!(
            sum == found || (sum - found).abs() <= 1e-9 * sum,
            "{sum} {found}"
        );
    }
    assert_eq!(dags[0].lit_intervals(&ray), dags[1].lit_intervals(&ray));
}

/// Maps with a few blocks, open and closed.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..16_u8)
        .map(|seed| {
            let mut bytes = vec![seed * 16, seed.wrapping_mul(80), seed.wrapping_mul(64)];
            for i in 0..120_u8 {
                bytes.push(i.wrapping_mul(97) ^ seed.wrapping_mul(51));
            }
            bytes
        })
        .collect()
}
