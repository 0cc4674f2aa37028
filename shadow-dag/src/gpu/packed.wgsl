// Nodes of the packed form: the number of a shape, followed by the references
// that differ, in as many bits as the level needs.
//
// Needs
//   fn dag_word(index: u32) -> u32    the words of the shadows

// Words of the table of levels for each level. Nodes lie in the order of their sizes, 0 to 8
// stored references. The words are: the first node of each size; for each size the bit at
// which node 0 would begin if all nodes had it; the width of a shape number and that of a
// reference, in bits.
const dag_LEVEL_WORDS: u32 = 20u;

// A node: what its children are, the bit at which their references begin, and how many bits
// each has.
struct dag_Node {
    shape: u32,
    references: u32,
    width: u32,
}

// `width` bits, 1 to 32, from bit `at` of the words on; the first is the lowest.
fn dag_bits(at: u32, width: u32) -> u32 {
    let shift = at % 32u;
    var bits = dag_word(at / 32u) >> shift;
    if shift + width > 32u {
        bits |= dag_word(at / 32u + 1u) << (32u - shift);
    }
    if width == 32u {
        return bits;
    }
    return bits & ((1u << width) - 1u);
}

// How many references a node stores: the last size whose first node is not behind it. Found
// by bisection. `level` is where the words of its level begin.
fn dag_references(level: u32, node: u32) -> u32 {
    if node >= dag_word(level + 8u) {
        return 8u;
    }
    var size = select(0u, 4u, node >= dag_word(level + 4u));
    size += select(0u, 2u, node >= dag_word(level + size + 2u));
    return size + select(0u, 1u, node >= dag_word(level + size + 1u));
}

fn dag_node(dag: dag_Shadows, level: u32, reference: u32) -> dag_Node {
    let table = dag.levels + dag_LEVEL_WORDS * level;
    let references = dag_references(table, reference);
    let shape_width = dag_word(table + 18u);
    let width = dag_word(table + 19u);
    // Sums wrap modulo 2³², as the table was made.
    let at = dag_word(table + 9u + references) + reference * (shape_width + references * width);
    let shapes = select(dag.node_shapes, dag.slice_shapes, level == 0u);
    return dag_Node(dag_word(shapes + dag_bits(at, shape_width)), at + shape_width, width);
}

// The reference to child 0 to 7.
fn dag_child(node: dag_Node, child: u32) -> u32 {
    var slot = (node.shape >> (4u * child)) & 15u;
    if slot == 8u {
        return dag_LIT;
    }
    if slot == 9u {
        return dag_SHADOWED;
    }
    // From 10 on: the reference of the child in front of it plus slot − 10.
    var steps = 0u;
    var stored = child;
    while slot > 9u && stored > 0u {
        steps += slot - 10u;
        stored -= 1u;
        slot = (node.shape >> (4u * stored)) & 15u;
    }
    return dag_bits(node.references + slot * node.width, node.width) + steps;
}
