// The OR-scan down the rows of a grid: entry points. Each row becomes the OR of itself and
// all rows before it.
//
// A workgroup scans a block of 128 rows of 16 columns; the last row of each block
// goes to `carry`, which is scanned in the same way and then combined with all
// rows of the following block. Each invocation has a segment of 8 rows of a column, and
// the 16 segments of a column are combined in four steps. `scan_columns` gives the same
// result without barriers, which are slow where a processor plays the GPU: an invocation
// goes down a column by itself.

const COLUMNS: u32 = 16u;
const SEGMENTS: u32 = 16u;
const ROWS: u32 = 8u;

struct Parameters {
    rows: u32,
    columns: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> carry: array<u32>;

var<workgroup> totals: array<u32, 256>;

@compute @workgroup_size(256)
fn scan_block(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let column = workgroup.x * COLUMNS + local % COLUMNS;
    let segment = local / COLUMNS;
    let first = (workgroup.y * SEGMENTS + segment) * ROWS;
    let inside = column < parameters.columns;
    var values: array<u32, 8>;
    var sum = 0u;
    for (var i = 0u; i < ROWS; i += 1u) {
        if inside && first + i < parameters.rows {
            sum |= words[(first + i) * parameters.columns + column];
        }
        values[i] = sum;
    }
    totals[local] = sum;
    for (var step = 1u; step < SEGMENTS; step *= 2u) {
        workgroupBarrier();
        var other = 0u;
        if segment >= step {
            other = totals[local - step * COLUMNS];
        }
        workgroupBarrier();
        totals[local] |= other;
    }
    workgroupBarrier();
    if !inside {
        return;
    }
    var before = 0u;
    if segment > 0u {
        before = totals[local - COLUMNS];
    }
    for (var i = 0u; i < ROWS; i += 1u) {
        if first + i < parameters.rows {
            words[(first + i) * parameters.columns + column] = before | values[i];
        }
    }
    if segment == SEGMENTS - 1u {
        carry[workgroup.y * parameters.columns + column] = before | sum;
    }
}

// One invocation per word; the first block is complete already.
@compute @workgroup_size(64)
fn add_carry(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = SEGMENTS * ROWS * parameters.columns;
    let i = block + gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.rows * parameters.columns {
        words[i] |= carry[(i / block - 1u) * parameters.columns + i % parameters.columns];
    }
}

// One invocation per column.
@compute @workgroup_size(64)
fn scan_columns(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let column = gpu_index(workgroup, workgroups, local, 64u);
    if column >= parameters.columns {
        return;
    }
    var sum = 0u;
    for (var row = 0u; row < parameters.rows; row += 1u) {
        let i = row * parameters.columns + column;
        sum |= words[i];
        words[i] = sum;
    }
}
