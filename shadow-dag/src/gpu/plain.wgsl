// Nodes of the plain form: a word with two bits per child, followed by a word
// for each mixed child.
//
// Needs
//   fn dag_word(index: u32) -> u32    the words of the shadows

// A node: what its children are, and the word at which their references begin.
struct dag_Node {
    kinds: u32,
    references: u32,
}

fn dag_node(dag: dag_Shadows, level: u32, reference: u32) -> dag_Node {
    let first = dag_word(dag.levels + level) + reference;
    return dag_Node(dag_word(first), first + 1u);
}

// The reference to child 0 to 7. Mixed children have the upper bit of their kind set, so
// that counting those bits in front of a child finds its word.
fn dag_child(node: dag_Node, child: u32) -> u32 {
    let kind = (node.kinds >> (2u * child)) & 3u;
    if kind == 0u {
        return dag_SHADOWED;
    }
    if kind == 1u {
        return dag_LIT;
    }
    let before = node.kinds & 0xaaaau & ((1u << (2u * child)) - 1u);
    return dag_word(node.references + countOneBits(before));
}
