/* Threaded red-black trees: balanced search trees whose nodes are also linked in order, so that
 * the first, the next and the previous node cost O(1) (Reichardt, Tab. 10-1).
 *
 * Nodes live in an array of the caller and are named by 32-bit indices; any number of trees may
 * share one array. Nothing is ever allocated. Nodes are ordered by key, then by rank; nodes
 * that agree in both stand in the order in which they were entered. */
#ifndef EVENTMILL_EVENT_RBTREE_H
#define EVENTMILL_EVENT_RBTREE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* No node; at the same time the largest number of nodes. */
enum { EM_RBTREE_NONE = 0x7fffffff };

struct em_rbnode {
  double key; /* not NaN; key and rank are set by the caller before the node is entered */
  uint32_t rank;
  uint32_t parent; /* its highest bit: the node is red */
  uint32_t left, right;
  uint32_t previous, next; /* the thread */
};

struct em_rbtree {
  uint32_t root, first, last;
};

void em_rbtree_init(struct em_rbtree *tree);

/* Enters the node with index n, O(log size). */
void em_rbtree_insert(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n);

/* Takes out node n, which must be in the tree, O(log size); the key stays as it was. */
void em_rbtree_remove(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n);

/* Gives node n a new key; cheap when its place in the order stays. */
void em_rbtree_move(struct em_rbtree *tree, struct em_rbnode *node, uint32_t n, double key);

/* The first node whose key is not below `key`, or EM_RBTREE_NONE; O(log size). */
uint32_t em_rbtree_find(const struct em_rbtree *tree, const struct em_rbnode *node, double key);

/* Order, links, colours, equal black height, threads; *size (may be NULL) is set to the number of
 * nodes. `room` is the length of the array of nodes. */
bool em_rbtree_is_valid(const struct em_rbtree *tree, const struct em_rbnode *node, size_t room,
                        size_t *size);

#endif
