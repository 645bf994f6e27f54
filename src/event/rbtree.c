/* Threaded red-black trees on an array of nodes. */
#include "event/rbtree.h"

#include <assert.h>

#define NONE ((uint32_t)EM_RBTREE_NONE)
#define RED  0x80000000u

static uint32_t parent_of(const struct em_rbnode *node, uint32_t n) {
  return node[n].parent & ~RED;
}

static bool is_red(const struct em_rbnode *node, uint32_t n) {
  return n != NONE && (node[n].parent & RED);
}

static void paint_red(struct em_rbnode *node, uint32_t n) {
  node[n].parent |= RED;
}

static void paint_black(struct em_rbnode *node, uint32_t n) {
  node[n].parent &= ~RED;
}

static void set_parent(struct em_rbnode *node, uint32_t n, uint32_t parent) {
  node[n].parent = (node[n].parent & RED) | parent;
}

static bool is_before(const struct em_rbnode *a, const struct em_rbnode *b) {
  return a->key < b->key || (a->key == b->key && a->rank < b->rank);
}

/* Puts `child` where `old` hung below `parent`. */
static void replace_child(struct em_rbtree *tree, struct em_rbnode *node, uint32_t parent,
                          uint32_t old, uint32_t child) {
  if (parent == NONE)
    tree->root = child;
  else if (node[parent].left == old)
    node[parent].left = child;
  else
    node[parent].right = child;
}

static void rotate_left(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n) {
  const uint32_t up = node[n].right;
  const uint32_t across = node[up].left;
  const uint32_t parent = parent_of(node, n);
  node[n].right = across;
  if (across != NONE) set_parent(node, across, n);
  set_parent(node, up, parent);
  replace_child(tree, node, parent, n, up);
  node[up].left = n;
  set_parent(node, n, up);
}

static void rotate_right(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n) {
  const uint32_t up = node[n].left;
  const uint32_t across = node[up].right;
  const uint32_t parent = parent_of(node, n);
  node[n].left = across;
  if (across != NONE) set_parent(node, across, n);
  set_parent(node, up, parent);
  replace_child(tree, node, parent, n, up);
  node[up].right = n;
  set_parent(node, n, up);
}

static void rotate(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n, bool left) {
  if (left)
    rotate_left(tree, node, n);
  else
    rotate_right(tree, node, n);
}

void em_rbtree_init(struct em_rbtree *tree) {
  *tree = (struct em_rbtree){NONE, NONE, NONE};
}

/* Links n into the thread between two neighbours, either of which may be missing. */
static void thread(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n, uint32_t previous,
                   uint32_t next) {
  node[n].previous = previous;
  node[n].next = next;
  if (previous == NONE)
    tree->first = n;
  else
    node[previous].next = n;
  if (next == NONE)
    tree->last = n;
  else
    node[next].previous = n;
}

static void unthread(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n) {
  const uint32_t previous = node[n].previous;
  const uint32_t next = node[n].next;
  if (previous == NONE)
    tree->first = next;
  else
    node[previous].next = next;
  if (next == NONE)
    tree->last = previous;
  else
    node[next].previous = previous;
}

/* n is red; so may be its parent. Restores: no red node has a red child, the root is black. */
static void repair_insert(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n) {
  uint32_t parent = parent_of(node, n);
  while (is_red(node, parent)) {
    const uint32_t grand = parent_of(node, parent);
    const bool left = node[grand].left == parent;
    const uint32_t uncle = left ? node[grand].right : node[grand].left;
    if (is_red(node, uncle)) {
      paint_black(node, parent);
      paint_black(node, uncle);
      paint_red(node, grand);
      n = grand;
      parent = parent_of(node, n);
      continue;
    }
    if (n == (left ? node[parent].right : node[parent].left)) {
      rotate(tree, node, parent, left);
      parent = n;
    }
    paint_black(node, parent);
    paint_red(node, grand);
    rotate(tree, node, grand, !left);
    break;
  }
  paint_black(node, tree->root);
}

void em_rbtree_insert(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n) {
  uint32_t parent = NONE;
  uint32_t place = tree->root;
  bool left = false;
  assert(node[n].key == node[n].key);
  while (place != NONE) {
    parent = place;
    left = is_before(&node[n], &node[parent]);
    place = left ? node[parent].left : node[parent].right;
  }
  node[n].left = node[n].right = NONE;
  node[n].parent = parent | RED;
  if (parent == NONE) {
    tree->root = n;
    thread(tree, node, n, NONE, NONE);
  } else if (left) {
    node[parent].left = n;
    thread(tree, node, n, node[parent].previous, parent);
  } else {
    node[parent].right = n;
    thread(tree, node, n, parent, node[parent].next);
  }
  repair_insert(tree, node, n);
}

/* The paths through n (possibly NONE), a child of parent, lack one black node. */
static void repair_remove(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n,
                          uint32_t parent) {
  while (parent != NONE && !is_red(node, n)) {
    const bool left = node[parent].left == n;
    uint32_t sibling = left ? node[parent].right : node[parent].left;
    if (is_red(node, sibling)) {
      paint_black(node, sibling);
      paint_red(node, parent);
      rotate(tree, node, parent, left);
      sibling = left ? node[parent].right : node[parent].left;
    }
    uint32_t inner = left ? node[sibling].left : node[sibling].right;
    uint32_t outer = left ? node[sibling].right : node[sibling].left;
    if (!is_red(node, inner) && !is_red(node, outer)) {
      paint_red(node, sibling);
      n = parent;
      parent = parent_of(node, n);
      continue;
    }
    if (!is_red(node, outer)) {
      paint_black(node, inner);
      paint_red(node, sibling);
      rotate(tree, node, sibling, !left);
      outer = sibling;
      sibling = inner;
    }
    if (is_red(node, parent))
      paint_red(node, sibling);
    else
      paint_black(node, sibling);
    paint_black(node, parent);
    paint_black(node, outer);
    rotate(tree, node, parent, left);
    return;
  }
  if (n != NONE) paint_black(node, n);
}

/* n has two children: its successor, the leftmost node of its right branch, takes its place
 * and colour. */
static void remove_inner(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n,
                         uint32_t heir) {
  const uint32_t child = node[heir].right;
  const bool was_red = is_red(node, heir);
  uint32_t parent = parent_of(node, heir);
  if (parent == n) {
    parent = heir;
  } else {
    node[parent].left = child;
    if (child != NONE) set_parent(node, child, parent);
    node[heir].right = node[n].right;
    set_parent(node, node[heir].right, heir);
  }
  node[heir].left = node[n].left;
  set_parent(node, node[heir].left, heir);
  replace_child(tree, node, parent_of(node, n), n, heir);
  node[heir].parent = node[n].parent;
  if (!was_red) repair_remove(tree, node, child, parent);
}

void em_rbtree_remove(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n) {
  const uint32_t heir = node[n].next;
  unthread(tree, node, n);
  if (node[n].left != NONE && node[n].right != NONE) {
    remove_inner(tree, node, n, heir);
    return;
  }
  const uint32_t parent = parent_of(node, n);
  const uint32_t child = node[n].left != NONE ? node[n].left : node[n].right;
  replace_child(tree, node, parent, n, child);
  if (child != NONE) set_parent(node, child, parent);
  if (!is_red(node, n)) repair_remove(tree, node, child, parent);
}

void em_rbtree_move(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n, double key) {
  const uint32_t previous = node[n].previous;
  const uint32_t next = node[n].next;
  const bool stays =
      (previous == NONE || node[previous].key < key) && (next == NONE || key < node[next].key);
  if (stays) {
    node[n].key = key;
    return;
  }
  em_rbtree_remove(tree, node, n);
  node[n].key = key;
  em_rbtree_insert(tree, node, n);
}

uint32_t em_rbtree_find(const struct em_rbtree *tree, const struct em_rbnode *node, double key) {
  uint32_t found = NONE;
  uint32_t place = tree->root;
  while (place != NONE) {
    if (node[place].key < key) {
      place = node[place].right;
    } else {
      found = place;
      place = node[place].left;
    }
  }
  return found;
}

/* Colours, links to the parent, and the black height of a branch; -1 when something is wrong. */
static int black_height(const struct em_rbnode *node, size_t room, uint32_t n, uint32_t parent,
                        int depth) {
  if (n == NONE) return 0;
  if (n >= room || depth > 64 || parent_of(node, n) != parent) return -1;
  if (is_red(node, n) && (is_red(node, node[n].left) || is_red(node, node[n].right))) return -1;
  const int left = black_height(node, room, node[n].left, n, depth + 1);
  const int right = black_height(node, room, node[n].right, n, depth + 1);
  if (left < 0 || left != right) return -1;
  return left + (is_red(node, n) ? 0 : 1);
}

static size_t branch_size(const struct em_rbnode *node, uint32_t n) {
  if (n == NONE) return 0;
  return 1 + branch_size(node, node[n].left) + branch_size(node, node[n].right);
}

/* The node that the tree's shape, not the thread, makes the successor of n. */
static uint32_t climb_next(const struct em_rbnode *node, uint32_t n) {
  if (node[n].right != NONE) {
    n = node[n].right;
    while (node[n].left != NONE)
      n = node[n].left;
    return n;
  }
  uint32_t parent = parent_of(node, n);
  while (parent != NONE && node[parent].right == n) {
    n = parent;
    parent = parent_of(node, n);
  }
  return parent;
}

bool em_rbtree_is_valid(const struct em_rbtree *tree, const struct em_rbnode *node, size_t room,
                        size_t *size) {
  if (size) *size = 0;
  if (tree->root == NONE) return tree->first == NONE && tree->last == NONE;
  if (is_red(node, tree->root)) return false;
  if (black_height(node, room, tree->root, NONE, 0) < 0) return false;
  uint32_t n = tree->root;
  while (node[n].left != NONE)
    n = node[n].left;
  if (n != tree->first || node[n].previous != NONE) return false;
  size_t counted = 1;
  for (uint32_t next = climb_next(node, n); next != NONE; next = climb_next(node, n)) {
    if (node[n].next != next || node[next].previous != n) return false;
    if (is_before(&node[next], &node[n])) return false;
    n = next;
    counted++;
  }
  if (size) *size = counted;
  return node[n].next == NONE && n == tree->last && counted == branch_size(node, tree->root);
}
