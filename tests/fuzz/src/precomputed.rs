//! Files of precomputed shadows.

use glam::{DMat4, IVec3, Vec3};
use gpu_backend::Cpu;
use shadow_dag::{
    Builder, DepthMap, FilterSize, Form, LightEntry, LightSpace, Ray, Resolution, ShadowDag,
    ShadowSet, Slices,
};

use super::Bytes;
use super::bytes::crc32;

/// Where in a file of several grids the grids are, if its directory can be believed.
fn grids(file: &[u8]) -> Vec<std::ops::Range<usize>> {
    let word = |at: usize| {
        let bytes = file.get(at..at + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?) as usize)
    };
    let read = || {
        let (lights, grids) = (word(16)?.min(64), word(20)?.min(64));
        let lengths = 24 + 32 * lights;
        let mut begin = lengths + 8 * grids;
        let places = (0..grids).map(|grid| {
            let end = begin.saturating_add(word(lengths + 8 * grid)?);
            Some(std::mem::replace(&mut begin, end)..end)
        });
        places.collect::<Option<Vec<_>>>()
    };
    read().unwrap_or_default()
}

/// Gives a file the checksums that its content has: they would keep almost all changes from
/// being read.
fn seal(file: &mut [u8]) {
    fn grid(bytes: &mut [u8]) {
        if bytes.len() > 16 {
            let sum = crc32(&bytes[16..]);
            bytes[12..16].copy_from_slice(&sum.to_le_bytes());
        }
    }
    if !file.starts_with(b"CPVSSET\0") {
        return grid(file);
    }
    let places = grids(file);
    for place in &places {
        if let Some(bytes) = file.get_mut(place.clone()) {
            grid(bytes);
        }
    }
    if let Some(first) = places.first().filter(|first| first.start <= file.len()) {
        let sum = crc32(&file[16..first.start]);
        file[12..16].copy_from_slice(&sum.to_le_bytes());
    }
}

/// Asks a grid about a few places, one by one, in a batch and in another form.
fn ask<B: AsRef<[u8]> + Sync>(dag: &ShadowDag<B>, bytes: &mut Bytes<'_>) {
    let cpu = Cpu::single_threaded();
    let side = dag.resolution().side();
    let mut place = || match bytes.byte() {
        0 => bytes.word() as i32,
        byte => (u64::from(byte - 1) * u64::from(side) / 254) as i32,
    };
    let voxels: Vec<IVec3> = (0..24)
        .map(|_| IVec3::from([(); 3].map(|()| place())))
        .collect();
    let size = FilterSize::new(5).expect("an odd width");
    let places: Vec<Vec3> = voxels.iter().map(|voxel| voxel.as_vec3() + 0.25).collect();
    let mut lit = vec![false; voxels.len()];
    let (mut hard, mut soft) = (vec![0.0; voxels.len()], vec![0.0; voxels.len()]);
    let same_lengths = "as many answers as questions";
    dag.is_lit_batch(&cpu, &voxels, &mut lit)
        .expect(same_lengths);
    dag.filter_batch(&cpu, &voxels, size, &mut hard)
        .expect(same_lengths);
    (dag.filter_bilinear_batch(&cpu, &places, size, &mut soft)).expect(same_lengths);
    let other = match dag.form() {
        Form::Plain => Form::Packed,
        _ => Form::Plain,
    };
    let other = dag.to_form(other).ok();
    for (i, voxel) in voxels.into_iter().enumerate() {
        assert_eq!(lit[i], dag.is_lit(voxel), "{voxel}");
        assert_eq!(hard[i], dag.filter(voxel, size), "{voxel}");
        assert_eq!(soft[i], dag.filter_bilinear(places[i], size), "{voxel}");
        if let Some(other) = &other {
            assert_eq!(lit[i], other.is_lit(voxel), "{voxel} in another form");
        }
        let _ = dag.visibility(voxel, voxel.saturating_add(IVec3::splat(9)));
        let texel = voxel.truncate().as_uvec2();
        if texel.max_element() < side {
            let _ = dag.depth(texel);
        }
    }
    // A ray crosses as many volumes as there are slices, of one voxel each at worst.
    if side <= 1024 {
        let ray = Ray::new(places[0], Vec3::new(0.3, 0.7, -0.5), f32::INFINITY);
        if let Ok(ray) = ray {
            let parts = dag.lit_intervals(&ray);
            assert!(parts.iter().flatten().is_sorted(), "{parts:?}");
        }
    }
    if let Some(light) = dag.light() {
        for place in &places {
            let voxel = light.voxel(dag.resolution(), *place);
            assert!(voxel.is_none_or(|voxel| voxel.is_finite()), "{place}");
            let normal = light.normal(*place, Vec3::Y);
            let is_unit = normal == Vec3::ZERO || normal.is_normalized();
            assert!(is_unit, "{normal} at {place} of {light:?}");
            if let Some(voxel) = voxel {
                let _ = dag.filter(size.bias(voxel, normal), size);
            }
        }
    }
    let _ = dag.sizes();
}

/// What reads a file of shadows gives an error or shadows that can be asked: in place, and
/// with compressed grids. The first byte says whether checksums are mended before.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let is_sealed = bytes.byte() < 224;
    // Questions take their places from the end of the file: it is there already.
    let mut file = bytes.rest().to_vec();
    if is_sealed {
        seal(&mut file);
    }
    let questions = file[file.len().saturating_sub(120)..].to_vec();
    let _ = LightEntry::directory(&file);
    if let Ok(set) = ShadowSet::from_bytes(&file) {
        for grid in set.grids().take(8) {
            ask(grid, &mut Bytes::new(&questions));
        }
        let again = set.to_bytes();
        assert!(
            ShadowSet::from_bytes(&again).is_ok(),
            "what is written is read"
        );
    }
    if let Ok(set) = ShadowSet::read(&file) {
        for grid in set.grids().take(8) {
            ask(grid, &mut Bytes::new(&questions));
        }
        let compressed = set.compress();
        let again = ShadowSet::read(&compressed).expect("what is compressed is read");
        for (grid, again) in set.grids().zip(again.grids()) {
            let packed = grid.to_form(Form::Packed).map(ShadowDag::into_bytes);
            assert_eq!(packed.ok().as_deref(), Some(again.as_bytes()));
        }
    }
}

/// Grids and sets in every form, with a light and without.
///
/// # Panics
/// Never: they are sound.
pub fn seeds() -> Vec<Vec<u8>> {
    let cpu = Cpu::single_threaded();
    let grid = |side: u32, light: bool| {
        let depth = |i: u32| match (i % side / 3 + i / side / 4) % 3 {
            0 => 0.2,
            1 => (i % side) as f32 / side as f32,
            _ => f32::INFINITY,
        };
        let enter: Vec<f32> = (0..side * side).map(depth).collect();
        let exit: Vec<f32> = enter.iter().map(|depth| depth + 0.3).collect();
        let resolution = Resolution::new(side).expect("a power of two");
        let map = DepthMap::new(resolution, Slices::Linear, &enter).expect("a square map");
        let mut map = map.with_exit(&exit).expect("a square map");
        if light {
            let view = DMat4::from_rotation_x(0.7);
            let space = LightSpace::orthographic(view, 3.0, 4.0, -1.0, 9.0);
            map = map.with_light(space.expect("a light"));
        }
        Builder::new().build(&cpu, &map).expect("a map in memory")
    };
    let mut files = Vec::new();
    for (side, light) in [(8, false), (16, true), (32, false)] {
        let plain = grid(side, light);
        let packed = plain.to_form(Form::Packed).expect("few nodes");
        files.extend([plain.compress(), packed.into_bytes(), plain.into_bytes()]);
    }
    let set = ShadowSet::new(vec![
        vec![grid(8, true)],
        vec![grid(16, false), grid(16, true)],
    ]);
    let set = set.expect("grids of one resolution");
    let packed = set.to_form(Form::Packed).expect("few nodes");
    files.extend([set.compress(), set.to_bytes(), packed.to_bytes()]);
    (files.iter())
        .map(|file| [&[0], file.as_slice()].concat())
        .collect()
}
