// Curves of what the rays of texels meet of listed candidates: entry points, one invocation
// per texel, 8 x 8 neighbours together. A dispatch spends so many iterations of loops; curves
// that are not finished wait in a buffer, with the candidate that comes next.

struct MeetParameters {
    // Of the map.
    width: u32,
    height: u32,
    // Invocations of this dispatch, a whole number of squares of 8 x 8 texels, and the first
    // of these squares.
    texels: u32,
    first_square: u32,
    // Levels of squares.
    levels: u32,
    // 1 for the dispatch that starts curves.
    starts: u32,
    // Iterations to be spent, and those of a candidate that is looked at, of a segment that is
    // asked for, and of one that is put in.
    budget: i32,
    look: i32,
    ask: i32,
    insertion: i32,
}

@group(0) @binding(0) var<uniform> parameters: MeetParameters;
// Four times the number of a candidate and more, sorted by square and then by candidate, and
// where those of each square begin.
@group(0) @binding(3) var<storage> listed: array<u32>;
@group(0) @binding(4) var<storage> starts: array<u32>;

// Enough for maps of 2^31 texels a side.
const LEVELS: u32 = 28u;
const NONE: u32 = 0xffffffffu;

// Of each level the next entry of its list, the end of the list, and the candidate.
var<private> next: array<u32, LEVELS>;
var<private> ends: array<u32, LEVELS>;
var<private> candidates: array<u32, LEVELS>;

fn candidate_at(level: u32) -> u32 {
    if next[level] < ends[level] {
        return listed[next[level]] / avsm_MOST_BINS;
    }
    return NONE;
}

// Finds the lists of a texel, from a candidate on.
fn seek(texel: vec2<u32>, first_candidate: u32) {
    let extent = vec2(parameters.width, parameters.height);
    var side = avsm_TILE;
    var first = 0u;
    for (var level = 0u; level < parameters.levels; level++) {
        let squares = avsm_bins(extent, side);
        let square = first + (texel.y / side) * squares.x + texel.x / side;
        var low = starts[square];
        ends[level] = starts[square + 1u];
        var high = ends[level];
        while low < high && first_candidate > 0u {
            let middle = low + (high - low) / 2u;
            if listed[middle] / avsm_MOST_BINS < first_candidate {
                low = middle + 1u;
            } else {
                high = middle;
            }
        }
        next[level] = low;
        candidates[level] = candidate_at(level);
        first += squares.x * squares.y;
        side *= 2u;
    }
}

// The least candidate of all levels, which is taken from its list.
fn take() -> u32 {
    var least = NONE;
    var from_level = 0u;
    for (var level = 0u; level < parameters.levels; level++) {
        if candidates[level] < least {
            least = candidates[level];
            from_level = level;
        }
    }
    if least != NONE {
        next[from_level] += 1u;
        candidates[from_level] = candidate_at(from_level);
    }
    return least;
}

fn texel_of(i: u32) -> vec2<u32> {
    let square = parameters.first_square + i / 64u;
    let columns = (parameters.width + 7u) / 8u;
    return 8u * vec2(square % columns, square / columns) + vec2(i % 8u, i / 8u % 8u);
}

fn is_in_map(texel: vec2<u32>) -> bool {
    return texel.x < parameters.width && texel.y < parameters.height;
}

// Where an unfinished curve has the candidate to go on with, and which of its segments.
const GO_ON: u32 = 2u + avsm_CAPACITY + 3u * avsm_VALUES;

@compute @workgroup_size(64)
fn meet(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let texel = texel_of(i);
    if i >= parameters.texels || !is_in_map(texel) {
        return;
    }
    var curve: avsm_Curve;
    var candidate = 0u;
    var part = 0u;
    if parameters.starts == 0u {
        candidate = unfinished[place(i, GO_ON)];
        part = unfinished[place(i, GO_ON + 1u)];
        if candidate == NONE {
            return;
        }
        curve = resume(i);
    }
    seek(texel, candidate);
    candidate = take();
    var budget = parameters.budget;
    // Parts of the candidate, none as long as it is not known to touch the texel.
    var parts = 0u;
    var is_known = false;
    loop {
        var segment: avsm_Segment;
        var is_clear = true;
        // The next segment that takes light: two loops, so that neighbours wait for each
        // other there, and ask and insert together.
        while is_clear && candidate != NONE && budget > 0 {
            while part >= parts && candidate != NONE && budget > 0 {
                if is_known {
                    candidate = take();
                    part = 0u;
                    parts = 0u;
                }
                is_known = candidate != NONE;
                if is_known {
                    let touched = avsm_candidate_texels(candidate);
                    if all(touched.xy <= texel) && all(texel < touched.zw) {
                        parts = avsm_candidate_segment_count(candidate);
                    }
                }
                budget -= parameters.look;
            }
            if part < parts {
                segment = avsm_candidate_segment(candidate, texel, part);
                part += 1u;
                is_clear = true;
                for (var c = 0u; c < avsm_CHANNELS; c++) {
                    is_clear = is_clear && segment.optical_depth[c] == 0.0;
                }
                budget -= parameters.ask;
            }
        }
        if is_clear {
            break;
        }
        avsm_insert(&curve, segment);
        budget -= parameters.insertion;
    }
    suspend(i, &curve);
    unfinished[place(i, GO_ON)] = candidate;
    unfinished[place(i, GO_ON + 1u)] = part;
}

@compute @workgroup_size(64)
fn finish(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let texel = texel_of(i);
    if i >= parameters.texels || !is_in_map(texel) {
        return;
    }
    var curve = resume(i);
    if unfinished[place(i, GO_ON)] != NONE {
        // Some are missing: no bound but 1.
        curve.insertions = avsm_INCOMPLETE;
    }
    avsm_finish(&curve);
    avsm_store(texel.y * parameters.width + texel.x, &curve);
}
