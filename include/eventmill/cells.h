/* Cells of a drum: sectors (tubes cut into cells of equal volume, seen along the axis) and rings
 * (equal cross-section, seen from the side). Source: Reichardt 2005, 16.1 and 16.2. The drum's axis
 * is y, from 0 to `length`. */
#ifndef EVENTMILL_CELLS_H
#define EVENTMILL_CELLS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum em_cells_kind { EM_CELLS_SECTORS, EM_CELLS_RINGS };

struct em_cells {
  enum em_cells_kind kind;
  double radius, length; /* m */
  size_t count;          /* of all cells */
  size_t slices;         /* sectors: along the axis */
  size_t tubes;          /* sectors: tubes; rings: cells along the radius */
  size_t columns;        /* rings: cells along the axis */
  double *edge;          /* tubes + 1, m, radii, owned */
  size_t *in_tube;       /* tubes, sectors of each, owned */
  size_t *first;         /* tubes, index of the first sector of each within a slice, owned */
  size_t per_slice;
};

/* About `sectors` cells per slice in `tubes` tubes. From the outside inwards, each tube has the
 * whole number of sectors that is nearest to equal widths of the tubes that are left, and its inner
 * radius is set so that each sector has the same volume; all cells are equal. NULL: no memory, or
 * sectors < tubes. */
struct em_cells *em_cells_sectors(double radius, double length, size_t tubes, size_t sectors,
                                  size_t slices);

/* At least `least` rings, as square as whole numbers allow. NULL: no memory. */
struct em_cells *em_cells_rings(double radius, double length, size_t least);
void em_cells_free(struct em_cells *cells);

/* The cell of a point; `count` outside by more than 1e-6 of the drum's size (contacts with its
 * walls lie on them to rounding). Angle from +x towards +z. */
size_t em_cells_find(const struct em_cells *cells, double x, double y, double z);

/* Volume of a cell (m³). */
double em_cells_volume(const struct em_cells *cells, size_t k);

/* Bounds of a cell: sectors {radius, angle (rad), y}, rings {radius, 0 … 2π, y}. */
void em_cells_bounds(const struct em_cells *cells, size_t k, double low[3], double high[3]);

#ifdef __cplusplus
}
#endif

#endif
