// Single voxels and texels: the shader's side of `ShadowDag::is_lit` and
// `ShadowDag::depth`. All arithmetic is in integers, so that results are those of the CPU
// bit by bit.
//
// Needs `PLAIN` or `PACKED`, and
//   fn dag_word(index: u32) -> u32    the words of the shadows

// References that name no node.
const dag_LIT: u32 = 0xffffffffu;
const dag_SHADOWED: u32 = 0xfffffffeu;

// Where things are in the words.
struct dag_Shadows {
    // Logarithm of the number of voxels along each axis.
    log2: u32,
    root: u32,
    // The top grid: logarithm of the number of cells along each axis, and the
    // word at which it begins.
    top: u32,
    cells: u32,
    // The words at which other things begin.
    masks: u32,
    levels: u32,
    slice_shapes: u32,
    node_shapes: u32,
}

// A cube of voxels that are all lit or all shadowed: a single voxel, or those of a node.
struct dag_Volume {
    lit: bool,
    // Binary logarithm of its width in voxels.
    shift: u32,
}

// Whether a reference names a node, which has both lit and shadowed voxels.
fn dag_is_mixed(reference: u32) -> bool {
    return reference < dag_SHADOWED;
}

// The number of voxels along each axis.
fn dag_side(dag: dag_Shadows) -> u32 {
    return 1u << dag.log2;
}

// The level of the root, which is the last. Nodes of level l are 8 · 2^l voxels wide.
fn dag_root_level(dag: dag_Shadows) -> u32 {
    return dag.log2 - 3u;
}

// The level of the nodes that the top grid names.
fn dag_top_level(dag: dag_Shadows) -> u32 {
    return dag_root_level(dag) - dag.top;
}

// The reference in that cell of the top grid which contains a voxel.
fn dag_top(dag: dag_Shadows, voxel: vec3<u32>) -> u32 {
    let cell = voxel >> vec3(dag_top_level(dag) + 3u);
    return dag_word(dag.cells + ((cell.z << dag.top | cell.y) << dag.top | cell.x));
}

// The octant of a node of `level` > 0 that contains a voxel.
fn dag_octant(level: u32, voxel: vec3<u32>) -> u32 {
    let bits = (voxel >> vec3(level + 2u)) & vec3(1u);
    return bits.z << 2u | bits.y << 1u | bits.x;
}

// The 8×8 mask that a child of a node of level 0 names: rows 0 to 3 and rows 4 to 7.
fn dag_mask(dag: dag_Shadows, reference: u32) -> vec2<u32> {
    let at = dag.masks + 2u * reference;
    return vec2(dag_word(at), dag_word(at + 1u));
}

fn dag_mask_bit(mask: vec2<u32>, x: u32, y: u32) -> bool {
    let rows = select(mask.x, mask.y, (y & 4u) != 0u);
    return ((rows >> ((y & 3u) << 3u | (x & 7u))) & 1u) == 1u;
}

// The largest homogeneous volume around a voxel that is stored below a node of level
// `start`; the voxel's coordinates may be those in the grid or those in the node.
fn dag_descend(dag: dag_Shadows, start: u32, from_reference: u32, voxel: vec3<u32>) -> dag_Volume {
    var reference = from_reference;
    var level = start;
    while dag_is_mixed(reference) {
        let node = dag_node(dag, level, reference);
        if level == 0u {
            let slice = dag_child(node, voxel.z & 7u);
            if dag_is_mixed(slice) {
                return dag_Volume(dag_mask_bit(dag_mask(dag, slice), voxel.x, voxel.y), 0u);
            }
            return dag_Volume(slice == dag_LIT, 0u);
        }
        reference = dag_child(node, dag_octant(level, voxel));
        level -= 1u;
    }
    return dag_Volume(reference == dag_LIT, level + 3u);
}

// The largest homogeneous volume that is stored around a voxel, which must be in the grid.
fn dag_volume(dag: dag_Shadows, voxel: vec3<u32>) -> dag_Volume {
    return dag_descend(dag, dag_top_level(dag), dag_top(dag, voxel), voxel);
}

// Whether a voxel is lit. Voxels beside the grid and in front of it are lit; those behind
// the last slice are as those in it.
fn dag_is_lit(dag: dag_Shadows, voxel: vec3<i32>) -> bool {
    let side = i32(dag_side(dag));
    let near = vec3(voxel.xy, min(voxel.z, side - 1));
    if any(near < vec3(0)) || any(near >= vec3(side)) {
        return true;
    }
    return dag_volume(dag, vec3<u32>(near)).lit;
}

// The first shadowed slice of a texel; the number of slices if none is, and beside the map.
fn dag_depth(dag: dag_Shadows, texel: vec2<u32>) -> u32 {
    let side = dag_side(dag);
    if any(texel >= vec2(side)) {
        return side;
    }
    var reference = dag.root;
    var level = dag_root_level(dag);
    var front = 0u;
    while dag_is_mixed(reference) {
        let node = dag_node(dag, level, reference);
        if level == 0u {
            for (var z = 0u; z < 8u; z += 1u) {
                let slice = dag_child(node, z);
                var lit = slice == dag_LIT;
                if dag_is_mixed(slice) {
                    lit = dag_mask_bit(dag_mask(dag, slice), texel.x, texel.y);
                }
                if !lit {
                    return front + z;
                }
            }
            return front + 8u;
        }
        // A column turns from lit to shadowed once: if the near half is still lit at its
        // end, it is lit throughout.
        let quarter = dag_octant(level, vec3(texel, 0u));
        let near = dag_child(node, quarter);
        let half = 4u << level;
        level -= 1u;
        if dag_descend(dag, level, near, vec3(texel, half - 1u)).lit {
            front += half;
            reference = dag_child(node, 4u + quarter);
        } else {
            reference = near;
        }
    }
    return front + select(0u, 8u << level, reference == dag_LIT);
}
