// Whether the invocations of a subgroup are neighbours in their workgroup, in order, and still hand each other their values after having
// gone different ways: what kernels rely on in which they share work, and what no specification promises.

const GROUP: u32 = 64u;

// One word of each invocation: its number at the beginning, 1 if it found everything so.
@group(0) @binding(0) var<storage, read_write> words: array<u32>;

@compute @workgroup_size(GROUP)
fn neighbours(@builtin(local_invocation_index) lane: u32, @builtin(subgroup_invocation_id) own: u32, @builtin(subgroup_size) size: u32) {
    var value = 0u;
    if lane % 5u == 0u {
        // As particles beyond their cell's list: another way through memory, and a longer one.
        for (var k = 0u; k <= lane; k += 5u) {
            value = max(value, words[k]);
        }
    } else {
        value = words[lane];
    }
    let next = (own + 1u) % size;
    let good = lane % size == own && subgroupShuffle(value, next) == lane - own + next && subgroupShuffleXor(value, 1u) == (lane ^ 1u)
        && subgroupShuffleXor(value, 2u) == (lane ^ 2u);
    words[lane] = select(0u, 1u, good);
}
