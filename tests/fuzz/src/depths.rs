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

/// In which slice each depth is.
fn slices(map: (Resolution, Slices), depths: &[f32]) -> Vec<i32> {
    let (resolution, slices) = map;
    let slice = |depth: &f32| slices.boundary(resolution, f64::from(*depth)) as i32;
    depths.iter().map(slice).collect()
}

/// Voxels of the shadows of a map are lit where its depths say so, in either form of the
/// nodes, and what else can be asked agrees with the voxels.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    // Most of what there is to find is in small maps already, of which many more can be tried.
    let side = match bytes.byte() {
        0..160 => 8,
        160..248 => 16,
        _ => 32,
    };
    let resolution = Resolution::new(side).expect("a power of two");
    let rule = bytes.one_of(&[Rule::Aligned, Rule::Kampe2015, Rule::Sintorn2014]);
    let spacing = match bytes.below(4) {
        0 => Slices::logarithmic(0.01, 1.0).expect("two distances"),
        _ => Slices::Linear,
    };
    let enter = depths(&mut bytes, side);
    let exit = bytes.flag().then(|| depths(&mut bytes, side));
    let mut map = DepthMap::new(resolution, spacing, &enter).expect("a square map");
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
    let exit = exit.as_ref().unwrap_or(&enter);
    let [enter, exit] = [&enter, exit].map(|depths| slices((resolution, spacing), depths));
    let forms = match bytes.flag() {
        true => [&plain, &packed],
        false => [&packed, &plain],
    };
    is_direct(forms, &enter, &exit);
    for _ in 0..3 {
        ask(forms, &mut bytes);
    }
}

/// The first graph has the voxels of the map's own depths; those inside of a solid, where
/// either is right, are those of the second one.
fn is_direct(forms: [&ShadowDag; 2], enter: &[i32], exit: &[i32]) {
    let side = forms[0].resolution().side() as i32;
    let texels = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    for ((x, y), (&enter, &exit)) in texels.zip(enter.iter().zip(exit)) {
        for z in 0..side {
            let at = IVec3::new(x, y, z);
            let lit = forms[0].is_lit(at);
            let expected = match (z < enter, z >= exit.max(enter)) {
                (true, _) => true,
                (_, true) => false,
                _ => forms[1].is_lit(at),
            };
            assert_eq!(lit, expected, "{at}");
        }
    }
    // A surface behind the last slice shadows nothing, however far behind it one asks.
    let outside = [[-1, 0, 0], [0, side, 0], [side, 0, side], [0, 0, -1]].map(IVec3::from);
    assert!(outside.iter().all(|at| forms[0].is_lit(*at)));
    let behind = IVec3::new(0, 0, side);
    assert_eq!(forms[0].is_lit(behind), forms[0].is_lit(behind - IVec3::Z));
}

/// A filter, a box, a column or a ray, against the voxels in them.
fn ask(forms: [&ShadowDag; 2], bytes: &mut Bytes<'_>) {
    let side = forms[0].resolution().side() as i32;
    let [x, y, z] = [(); 3].map(|()| bytes.below(side as usize + 8) as i32 - 4);
    let at = IVec3::new(x, y, z);
    match bytes.below(4) {
        0 => is_count(forms, at, bytes.one_of(&[1, 3, 3, 5, 9, 9, 9, 33])),
        1 => {
            let last = at + IVec3::from([(); 3].map(|()| bytes.below(12) as i32));
            is_mix(forms, at, last);
        }
        2 => {
            let texel = [x, y].map(|at| at.clamp(0, side - 1));
            let is_dark = |z: &i32| !forms[0].is_lit(IVec3::new(texel[0], texel[1], *z));
            let depth = (0..side).find(is_dark).unwrap_or(side);
            let found = forms.map(|dag| dag.depth(texel.map(|at| at as u32)) as i32);
            assert_eq!(found, [depth; 2], "{texel:?}");
        }
        _ => {
            let length = bytes.one_of(&[f32::INFINITY, 0.0, 1.0, 20.0]);
            let origin = at.as_vec3() + bytes.vector(1.0);
            let ray = Ray::new(origin, bytes.direction(), length).expect("finite numbers");
            let parts = forms[0].lit_intervals(&ray);
            let in_order = parts.iter().flatten().is_sorted() && parts.iter().all(|[a, b]| a < b);
            assert!(in_order, "{parts:?}");
            assert_eq!(parts, forms[1].lit_intervals(&ray));
            let sum: f64 = parts.iter().map(|[start, end]| end - start).sum();
            let found = forms[0].lit_length(&ray);
            assert_eq!(found, forms[1].lit_length(&ray));
            assert!(
                sum == found || (sum - found).abs() <= 1e-9 * sum,
                "{sum} {found}"
            );
        }
    }
}

/// A filter of this width counts the lit voxels in it.
fn is_count(forms: [&ShadowDag; 2], at: IVec3, width: u32) {
    let half = width as i32 / 2;
    let around = (-half..=half).flat_map(|dy| (-half..=half).map(move |dx| (dx, dy)));
    let lit = around.filter(|(dx, dy)| forms[0].is_lit(at + IVec3::new(*dx, *dy, 0)));
    let lit = lit.count() as u32;
    let size = FilterSize::new(width).expect("an odd width");
    let found = forms.map(|dag| dag.count_lit(at, size));
    assert_eq!(found, [lit; 2], "{at} {width}");
}

/// A box is lit, dark or both as its voxels are.
fn is_mix(forms: [&ShadowDag; 2], first: IVec3, last: IVec3) {
    let mut seen = [false; 2];
    for z in first.z..=last.z {
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                seen[usize::from(forms[0].is_lit(IVec3::new(x, y, z)))] = true;
            }
        }
    }
    let expected = match seen {
        [true, true] => Visibility::Mixed,
        [true, false] => Visibility::Shadowed,
        _ => Visibility::Lit,
    };
    let found = forms.map(|dag| dag.visibility(first, last));
    assert_eq!(found, [expected; 2], "{first} {last}");
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
