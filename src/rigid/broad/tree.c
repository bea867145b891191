/* Dynamic tree of boxes: leaves are proxies, the box of a node holds those of its two children.
 *
 * A leaf is inserted where it adds the least perimeter (surface area heuristic; a greedy descent, as in
 * Bittner et al. 2013 and Box2D). On the way back up, a node is exchanged with a grandchild where that
 * shrinks its parent's box. Costs log n for an insertion and log n + hits for a query. */
#include "rigid/broad/broad.h"

#include "base/assert.h"

#define NONE (-1)

typedef struct node {
    ll_aabb box;
    int32_t parent;
    int32_t child[2]; /* NONE in a leaf */
    int32_t proxy;    /* of a leaf; a free node: the next free one */
} node;

typedef struct tree {
    int32_t capacity, root, free, made; /* nodes made so far */
    int32_t pad[12];
    /* then node at[2 * capacity], int32_t leaf[capacity] */
} tree;

static node *nodes(const tree *t)
{
    return (node *)(t + 1);
}

static int32_t *leaves(const tree *t)
{
    return (int32_t *)(nodes(t) + 2 * t->capacity);
}

static size_t size(int32_t capacity)
{
    return (sizeof(tree) + (size_t)capacity * (2 * sizeof(node) + sizeof(int32_t)) + 63) & ~(size_t)63;
}

static void init(void *state, int32_t capacity)
{
    *(tree *)state = (tree){.capacity = capacity, .root = NONE, .free = NONE};
}

static inline double perimeter(ll_aabb b)
{
    return (b.upper.x - b.lower.x) + (b.upper.y - b.lower.y);
}

static int32_t take_node(tree *t)
{
    LL_ASSERT(t->free != NONE || t->made < 2 * t->capacity);
    if (t->free == NONE)
        return t->made++;
    int32_t i = t->free;
    t->free = nodes(t)[i].proxy;
    return i;
}

static void give_node(tree *t, int32_t i)
{
    nodes(t)[i] = (node){.proxy = t->free, .parent = NONE, .child = {NONE, NONE}};
    t->free = i;
}

static int32_t best_sibling(const tree *t, ll_aabb box)
{
    const node *at = nodes(t);
    int32_t i = t->root;
    while (at[i].child[0] != NONE) {
        double all = perimeter(ll_aabb_union(at[i].box, box));
        double grown = all - perimeter(at[i].box), cost[2];
        for (int k = 0; k < 2; k++) {
            const node *child = &at[at[i].child[k]];
            cost[k] = perimeter(ll_aabb_union(child->box, box)) + grown;
            if (child->child[0] != NONE)
                cost[k] -= perimeter(child->box);
        }
        if (all < cost[0] && all < cost[1])
            break;
        i = at[i].child[cost[1] < cost[0]];
    }
    return i;
}

static void refit(node *at, int32_t i)
{
    LL_VALIDATE(at[at[i].child[0]].parent == i && at[at[i].child[1]].parent == i);
    at[i].box = ll_aabb_union(at[at[i].child[0]].box, at[at[i].child[1]].box);
}

/* Exchanges one child of `i` with a grandchild on the other side, where that shrinks the other child's box
 * most. */
static void rotate(node *at, int32_t i)
{
    double best = 0;
    int side = 0, grand = 0;
    for (int s = 0; s < 2; s++) {
        int32_t upper = at[i].child[s], lower = at[i].child[1 - s];
        if (at[lower].child[0] == NONE)
            continue;
        for (int g = 0; g < 2; g++) {
            int32_t stays = at[lower].child[1 - g];
            double gain = perimeter(at[lower].box) - perimeter(ll_aabb_union(at[upper].box, at[stays].box));
            if (gain > best) {
                best = gain;
                side = s;
                grand = g;
            }
        }
    }
    if (best <= 0)
        return;
    int32_t upper = at[i].child[side], lower = at[i].child[1 - side], rises = at[lower].child[grand];
    at[i].child[side] = rises;
    at[rises].parent = i;
    at[lower].child[grand] = upper;
    at[upper].parent = lower;
    refit(at, lower);
}

static void insert(void *state, const ll_aabb *boxes, int32_t proxy)
{
    tree *t = state;
    node *at = nodes(t);
    int32_t leaf = take_node(t);
    at[leaf] = (node){.box = boxes[proxy], .parent = NONE, .child = {NONE, NONE}, .proxy = proxy};
    leaves(t)[proxy] = leaf;
    if (t->root == NONE) {
        t->root = leaf;
        return;
    }
    int32_t sibling = best_sibling(t, boxes[proxy]), parent = at[sibling].parent, joint = take_node(t);
    at[joint] = (node){.parent = parent, .child = {sibling, leaf}, .proxy = NONE};
    at[sibling].parent = joint;
    at[leaf].parent = joint;
    if (parent == NONE)
        t->root = joint;
    else
        at[parent].child[at[parent].child[1] == sibling] = joint;
    for (int32_t i = joint; i != NONE; i = at[i].parent) {
        refit(at, i);
        rotate(at, i);
    }
}

static void remove_proxy(void *state, int32_t proxy)
{
    tree *t = state;
    node *at = nodes(t);
    int32_t leaf = leaves(t)[proxy], parent = at[leaf].parent;
    LL_ASSERT(at[leaf].child[0] == NONE && at[leaf].proxy == proxy); /* a leaf, and its own */
    give_node(t, leaf);
    if (parent == NONE) {
        t->root = NONE;
        return;
    }
    int32_t sibling = at[parent].child[at[parent].child[0] == leaf], above = at[parent].parent;
    at[sibling].parent = above;
    if (above == NONE)
        t->root = sibling;
    else
        at[above].child[at[above].child[1] == parent] = sibling;
    give_node(t, parent);
    for (int32_t i = above; i != NONE; i = at[i].parent)
        refit(at, i);
}

static void move(void *state, const ll_aabb *boxes, int32_t proxy)
{
    remove_proxy(state, proxy);
    insert(state, boxes, proxy);
}

/* Depth first without a stack: down to the first child, else to the right sibling of the nearest ancestor. */
static void query(const void *state, const ll_aabb *boxes, ll_aabb box, ll_broad_visit *visit, void *context)
{
    (void)boxes;
    const tree *t = state;
    const node *at = nodes(t);
    int32_t i = t->root;
    while (i != NONE) {
        if (ll_aabb_overlap(at[i].box, box)) {
            if (at[i].child[0] != NONE) {
                i = at[i].child[0];
                continue;
            }
            visit(context, at[i].proxy);
        }
        while (at[i].parent != NONE && at[at[i].parent].child[1] == i)
            i = at[i].parent;
        i = at[i].parent == NONE ? NONE : at[at[i].parent].child[1];
    }
}

const ll_broad_phase ll_broad_tree = {.name = "tree",
                                      .help =
                                          "Dynamic tree of boxes: log n per move, log n + hits per query.",
                                      .size = size,
                                      .init = init,
                                      .insert = insert,
                                      .remove = remove_proxy,
                                      .move = move,
                                      .query = query};
