// Fills pictures from samples: the shader's side of `Choice` and `Filling`. One invocation
// per sample (join_subsets) or per pixel (fill_between).

struct Grid {
    // Pixels of the picture.
    columns: u32,
    rows: u32,
    // Samples: every `block`-th pixel, and the last.
    sample_columns: u32,
    sample_rows: u32,
    // Windows over the samples: those of a row, and all.
    window_columns: u32,
    window_count: u32,
    // Pixels per side of a block, and samples per side of a window.
    block: u32,
    window: u32,
    // Whether only samples that resemble a pixel count; else the filter is a Gaussian.
    bilateral: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

struct Ray {
    origin: vec3<f32>,
    length: f32,
    direction: vec3<f32>,
    padding: f32,
}

// Stands for the ray of what has none to itself.
const NONE: u32 = 0xffffffffu;
// Longer rays count as this long.
const FARTHEST: f32 = 1e18;
// How fast the resemblance falls with the relative distance from the plane, and with the
// angle between the normals.
const PER_LENGTH: f32 = 10.0;
const PER_TURN: f32 = 2.5;

@group(0) @binding(0) var<uniform> grid: Grid;
@group(0) @binding(1) var<storage> rays: array<Ray>;
// The plane of the surface that each pixel sees, which is the points P with q · P = 1: q,
// and the plane's distance 1 / |q|; zeros for the sky.
@group(0) @binding(2) var<storage> planes: array<vec4<f32>>;
// The number of the ray that a sample or a pixel has to itself.
@group(0) @binding(3) var<storage> own: array<u32>;
// The light of all rays that were gathered.
@group(0) @binding(4) var<storage> gathered: array<vec4<f32>>;
// The light of the samples, row by row.
@group(0) @binding(5) var<storage> samples: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4<f32>>;

// The pixel of a sample.
fn pixel_of(sample: vec2<u32>) -> u32 {
    let place = min(sample * grid.block, vec2(grid.columns, grid.rows) - 1u);
    return place.y * grid.columns + place.x;
}

// Where the light of a sample was gathered: subsets of the samples come one after the other.
fn slot_of(sample: vec2<u32>) -> u32 {
    let n = grid.window;
    let subset = (sample.y % n) * n + sample.x % n;
    return subset * grid.window_count + (sample.y / n) * grid.window_columns + sample.x / n;
}

// Tukey's biweight: 1 at 0, falling to 0 at 1.
fn biweight(e: f32) -> f32 {
    let limited = min(e, 2.0);
    let left = max(1.0 - limited * limited, 0.0);
    return left * left;
}

// How much what a sample sees resembles what a pixel sees, from 0 to 1.
fn resemblance(pixel: u32, sample: u32) -> f32 {
    if grid.bilateral == 0u {
        return 1.0;
    }
    let here = planes[pixel];
    let there = planes[sample];
    if here.w == 0.0 || there.w == 0.0 {
        return select(0.0, 1.0, here.w == there.w);
    }
    let ratio = min(rays[sample].length, FARTHEST) * dot(here.xyz, rays[sample].direction);
    let cosine = dot(here.xyz, there.xyz) * here.w * there.w;
    return biweight(PER_LENGTH * abs(ratio - 1.0)) * biweight(PER_TURN * (1.0 - cosine));
}

// The share of a window's width that is left at an offset, squared.
fn left_at(offset: i32) -> f32 {
    let n = i32(grid.window);
    let left = f32(n - abs(offset)) / f32(n);
    return left * left;
}

// The light of each sample, from those around it of all subsets, which share lights or steps.
@compute @workgroup_size(64)
fn join_subsets(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= grid.sample_columns * grid.sample_rows {
        return;
    }
    if own[i] != NONE {
        radiance[i] += vec4(gathered[own[i]].xyz, 0.0);
        return;
    }
    let place = vec2(i % grid.sample_columns, i / grid.sample_columns);
    let pixel = pixel_of(place);
    let n = grid.window;
    let size = vec2(i32(grid.sample_columns), i32(grid.sample_rows));
    var sum = vec3(0.0);
    for (var subset = 0u; subset < n * n; subset += 1u) {
        // The first sample of the subset from here on, and the one before it.
        let after = vec2<i32>((vec2(subset % n, subset / n) + n - place % n) % n);
        var mean = vec4(0.0);
        for (var tap = 0u; tap < 4u; tap += 1u) {
            let offset = after - i32(n) * vec2<i32>(vec2(tap & 1u, tap >> 1u));
            let weight = left_at(offset.y) * left_at(offset.x);
            let sample = vec2<i32>(place) + offset;
            if weight > 0.0 && all(sample >= vec2(0)) && all(sample < size) {
                let there = vec2<u32>(sample);
                let w = weight * resemblance(pixel, pixel_of(there));
                mean += w * vec4(gathered[slot_of(there)].xyz, 1.0);
            }
        }
        sum += mean.xyz / mean.w;
    }
    radiance[i] += vec4(sum / f32(n * n), 0.0);
}

// The weights of four samples along a side around a pixel, from the one in front of the
// sample that begins the pixel's block on.
fn weights_between(place: u32, side: u32) -> vec4<f32> {
    let start = place / grid.block * grid.block;
    let width = min(start + grid.block, side - 1u) - start;
    let f = select(0.0, f32(place - start) / f32(max(width, 1u)), width > 0u);
    if grid.bilateral != 0u {
        return vec4(0.0, 1.0 - f, f, 0.0);
    }
    return vec4(0.25 * (1.0 - f), 0.5 - 0.25 * f, 0.25 + 0.25 * f, 0.25 * f);
}

// The light of each pixel, from the samples around it.
@compute @workgroup_size(64)
fn fill_between(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= grid.columns * grid.rows {
        return;
    }
    if own[i] != NONE {
        radiance[i] += vec4(gathered[own[i]].xyz, 0.0);
        return;
    }
    let place = vec2(i % grid.columns, i / grid.columns);
    let across = weights_between(place.x, grid.columns);
    let down = weights_between(place.y, grid.rows);
    let last = vec2(grid.sample_columns, grid.sample_rows) - 1u;
    var mean = vec4(0.0);
    for (var tap = 0u; tap < 16u; tap += 1u) {
        let at = vec2(tap & 3u, tap >> 2u);
        let weight = across[at.x] * down[at.y];
        if weight > 0.0 {
            let sample = min(max(place / grid.block + at, vec2(1u)) - 1u, last);
            let w = weight * resemblance(i, pixel_of(sample));
            mean += w * vec4(samples[sample.y * grid.sample_columns + sample.x].xyz, 1.0);
        }
    }
    radiance[i] += vec4(mean.xyz / mean.w, 0.0);
}
