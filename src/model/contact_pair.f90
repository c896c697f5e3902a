!> A contact: two surfaces, the laws between them, and the history of its integration points.
!!
!! `contact_t` carries a contact from the records of the deck to its use: the reader of CONTact sets
!! what the deck gives, and `input_contact` resolves the surfaces, the integration points and the
!! numbers that the deck leaves to the program.
module contact_pair
  use base_kinds, only: wp
  use base_error, only: place_t
  use base_text, only: to_text
  use contact_type, only: contact_law_t, LARGEST_OPENINGS, MAX_LAW_PROP, SMOOTHING
  implicit none
  private
  public :: contact_t, surface_t, surface_basis_t, contact_points_t, contact_state_t, bond_t, &
            edge_part_t, assigned_law_t, control_points_t, &
            friction_points_t, option_text, is_integrated, is_released, release_of

  !> SCHEme: the points at which the laws act, and the bodies on which their tractions act.
  integer, parameter, public :: HALFPASS = 1 !! each integration point loads its own side
  integer, parameter, public :: BALANCED = 2 !! each integration point loads both sides with half
  !! of its traction
  integer, parameter, public :: MORTAR = 3   !! points of cells and control points load both sides

  integer, parameter, public :: MAX_POINT = 50 !! largest QUADrature in one direction

  !> Functions of the surface elements of one basis: N = C B with Bernstein polynomials B on
  !! [-1,1]^2, whose first direction varies fastest. Faces of Lagrange elements are written this
  !! way too.
  type :: surface_basis_t
    integer :: degree(2) = 1
    integer :: nsf = 0                       !! functions
    real(wp), allocatable :: c(:, :)         !! (nsf, nb) extraction, nb = product(degree + 1)
    real(wp), allocatable :: shp(:, :) !! (nsf, nq) N at the integration points, without weights
    real(wp), allocatable :: dshp(:, :, :)   !! (2, nsf, nq)
  end type surface_basis_t

  !> A part of an edge at a T-junction, and the element edge that adjoins it.
  type :: edge_part_t
    real(wp) :: own(2) = 0.0_wp              !! parameters of the edge, ascending
    integer :: elem = 0, edge = 0            !! the adjoining element and its edge
    real(wp) :: other(2) = 0.0_wp            !! parameters of that edge at own(1) and own(2)
  end type edge_part_t

  !> One side: elements with outward normal a_1 x a_2, and their connectivity.
  !! Edges 1 to 4 of an element: xi-, xi+, eta-, eta+. Corners 1 to 4: (-,-) (+,-) (-,+) (+,+).
  type :: surface_t
    character(:), allocatable :: name        !! as in the deck, such as: hemi 3-
    logical :: rigid = .false. !! its nodes are prescribed, and it has no integration points
    real(wp) :: thickness = 0.0_wp !! thickness of the body behind it [L]; 0: unknown or rigid
    integer :: nelem = 0
    type(surface_basis_t), allocatable :: basis(:)
    integer, allocatable :: ibasis(:)        !! (nelem)
    integer, allocatable :: first(:) !! (nelem+1) position in `node` of an element's first node
    integer, allocatable :: node(:)          !! nodes and control points of all elements
    real(wp), allocatable :: w(:)            !! (size(node)) weights; not allocated: all one
    integer, allocatable :: block(:), elem(:), face(:) !! (nelem) block, element, local face
    real(wp), allocatable :: width(:)        !! (nelem) square root of the reference area [L]
    !> (4, nelem) element across an edge; 0: the edge belongs to the outer boundary.
    integer, allocatable :: neighbour(:, :)
    integer, allocatable :: edge(:, :)       !! (4, nelem) edge of the neighbour; negative: reversed
    !> If an edge meets several edges, or only a part of one edge, its parts are listed. Those of
    !! edge k of element e begin at part_first(4(e-1)+k), and `neighbour` is one of the adjoining
    !! elements. The arrays are not allocated if there is no such edge.
    integer, allocatable :: part_first(:)    !! (4*nelem+1)
    type(edge_part_t), allocatable :: part(:)
    !> (4, nelem) The edge is collapsed to a point (triangles). Not allocated: no edge is collapsed.
    logical, allocatable :: point(:, :)
    integer, allocatable :: vertex(:, :)     !! (4, nelem) vertex at each corner
    integer, allocatable :: ring_first(:) !! (nvertex+1) position in ring_elem for each vertex
    integer, allocatable :: ring_elem(:)     !! elements around the vertices
    integer, allocatable :: ring_corner(:)   !! corners of these elements that lie at the vertex
    logical, allocatable :: outer(:)         !! (nvertex) the vertex lies on the outer boundary
    !> Control points of pressure (MORTar): the nodes or, if a function of the surface is negative
    !! somewhere, the vertices with bilinear functions (`hats`).
    integer :: ncontrol = 0
    logical :: hats = .false.
    integer, allocatable :: control_first(:) !! (nelem+1) position in `control` of each element
    integer, allocatable :: control(:)       !! control points of the elements
  end type surface_t

  !> A region of the reference configuration that decides which points are bonded: the half space
  !! that a normal points into, or a box.
  type :: bond_t
    logical :: is_except = .false.           !! points in the region are not bonded
    logical :: is_box = .false.
    real(wp) :: a(3) = 0.0_wp                !! point of the plane, or low corner [L]
    real(wp) :: b(3) = 0.0_wp                !! unit normal [-], or high corner [L]
  end type bond_t

  !> A law of a contact and its numbers.
  type :: assigned_law_t
    logical :: given = .false.               !! the deck gives this law
    type(contact_law_t) :: law
    real(wp) :: prop(MAX_LAW_PROP) = 0.0_wp  !! for its columns see contact_type or the law's file
    logical :: auto = .false.                !! the penalty follows from stiffness and element size
    real(wp) :: factor = 1.0_wp !! NORMal: the penalty, relative to that of AUTO alone [-]
    character(:), allocatable :: account     !! how AUTO found the penalty
    real(wp) :: tau = 0.0_wp                 !! time of VISCous [T]; 0: no VISCous
  end type assigned_law_t

  !> CONTact of the deck.
  type :: contact_t
    character(:), allocatable :: name
    type(place_t) :: place
    type(surface_t) :: side(2)
    !> Self-contact: both sides are the same surface. Side 1 is integrated over its cells, whose
    !! points are projected onto side 2.
    logical :: self = .false.
    type(assigned_law_t) :: normal, friction, cohesive
    !> PAIR: the penalty of bonded points acts between point and partner until the bond is released.
    logical :: on_pair = .false.
    real(wp) :: taper = 0.0_wp !! BORDer: width relative to an element [-]; 0: no BORDer
    integer :: scheme = 0                    !! HALFPASS, BALANCED or MORTAR; 0: not given
    logical :: balanced = .false.            !! BALANCED, and no side is rigid
    !> MORTAR: the penalties that act at points and at control points [F/L^3]. Their sum is the
    !! penalty of the deck; it may be larger with AUGMent.
    real(wp) :: point_penalty = 0.0_wp, control_penalty = 0.0_wp
    real(wp) :: after = -huge(1.0_wp)        !! AFTEr: earliest start of a step with friction [T]
    type(bond_t), allocatable :: bond(:) !! regions that decide which points are bonded
    real(wp) :: bond_gap = -1.0_wp           !! GAP [L]; negative: 1e-3 of the element size
    real(wp) :: released(2) = 0.0_wp !! normal and shear opening at which a bond is released [L]
    real(wp) :: strength = 0.0_wp            !! magnitude of the largest tractions of a bond [F/L^2]
    real(wp) :: depth = 0.0_wp               !! DEPTh: a deeper penetration is not contact [L]
    logical :: default_depth = .false.       !! the deck gives no DEPTh
    integer :: ngauss(2) = 5                 !! QUADrature: points of an element in each direction
    logical :: given_points = .false.        !! the deck gives QUADrature
    integer :: ncell = 1                     !! REFIne: cells of a refined element in one direction
    !> Integration points of an element: first those of the plain rule, which is QUADrature without
    !! REFIne, then those of the cells of REFIne.
    integer :: nq = 0, nplain = 0            !! all points; points of the plain rule
    real(wp), allocatable :: xi(:, :)        !! (2, nq)
    real(wp), allocatable :: wgt(:)          !! (nq)
  end type contact_t

  !> History of the integration points of one side. Point q of element e is number (e-1)*nq + q.
  type :: contact_points_t
    !> Element of the closest point on the other surface, where the next projection starts; 0: there
    !! is none.
    integer, allocatable :: closest(:)       !! (np)
    real(wp), allocatable :: closest_xi(:, :) !! (2, np)
    integer, allocatable :: closest_step(:)  !! (np) `closest` at the start of the step
    real(wp), allocatable :: closest_xi_step(:, :)
    !> Element of the stored sliding point on the other surface, which moves only when a step is
    !! accepted; 0: none.
    integer, allocatable :: slide(:)         !! (np)
    real(wp), allocatable :: slide_xi(:, :)  !! (2, np)
    real(wp), allocatable :: multiplier(:)   !! (np) pressure of the augmentation [F/L^2]
    real(wp), allocatable :: multiplier_step(:) !! (np) multiplier at the start of the step
    !> (np) `state` at the end of the previous step. A point that slipped begins the next step with
    !! the tangent of slip.
    integer, allocatable :: state_step(:)
    real(wp), allocatable :: slip_rate(:)    !! (np) rate of slip in the previous step [L/T]
    real(wp) :: dt = 0.0_wp                  !! time step [T]; 0: no time passes
    !> (np) At the end of the previous step, the point was beside the other surface and not far
    !! above it. Such a point enters the body over the boundary and is not pushed out through the
    !! face.
    logical, allocatable :: beside(:)
    logical :: new_step = .false.            !! the step has not been assembled yet
    logical, allocatable :: refined(:)       !! (nelem) the points of the cells are active
    !> Element of the partner on the other surface, found in the reference configuration; 0: the
    !! point is not bonded.
    integer, allocatable :: bond(:)          !! (np)
    real(wp), allocatable :: bond_xi(:, :)   !! (2, np)
    real(wp), allocatable :: area0(:)        !! (np) reference area of the point [L^2]
    real(wp), allocatable :: past(:, :)      !! (MAX_PAST, np) history of the cohesive law
    real(wp), allocatable :: past_step(:, :) !! (MAX_PAST, np) `past` at the start of the step
    real(wp), allocatable :: opening(:)      !! (np) current distance to the partner [L]
    real(wp), allocatable :: opening_step(:) !! (np) opening at the start of the step
    real(wp), allocatable :: energy(:, :) !! (3, np) elastic, damage, viscosity; per area [F/L]
    real(wp), allocatable :: bond_traction(:, :) !! (3, np) on area0 [F/L^2]
    !> (np) PAIR: weight of the normal law at the current projection in the last assembly [-]; the
    !! rest of the pressure acts between the point and its partner.
    real(wp), allocatable :: share(:)
    !> Results of the last assembly.
    integer, allocatable :: state(:)         !! (np) OPEN, STICK, SLIP, TOUCH
    real(wp), allocatable :: gap(:)          !! (np) [L]; huge where there is no projection
    real(wp), allocatable :: pressure(:)     !! (np) [F/L^2]
    real(wp), allocatable :: traction(:, :)  !! (3, np) traction on this side [F/L^2]
    real(wp), allocatable :: friction(:, :)  !! (3, np) frictional part of `traction` [F/L^2]
    !> (3, np) part of `traction` that is due to the normal law [F/L^2]; the rest is that of bonds.
    real(wp), allocatable :: normal(:, :)
    !> (3, np) part of the tangential displacement that is not slip [L].
    real(wp), allocatable :: elastic(:, :)
    real(wp), allocatable :: slip(:)         !! (np) length of the slip [L]
    real(wp), allocatable :: limit(:)        !! (np) friction at which the point slips [F/L^2]
    real(wp), allocatable :: limit_step(:)   !! (np) limit at the start of the step
    real(wp), allocatable :: pressed(:)      !! (np) energy of the pressure, times the area [F L]
    real(wp), allocatable :: area(:)         !! (np) current area of the point [L^2]
    !> MORTAR: (NSPREAD, n) sums for smooth fields (contact_smooth), taken over the points of the
    !! cells of both sides: the share of the values at each point with which it loads this side,
    !! times the functions of the n nodes of the side there or at the projection of the point. If
    !! the array is not allocated, the fields are found from the integration points.
    real(wp), allocatable :: spread(:, :)
  end type contact_points_t

  !> MORTAR: multipliers of the control points of one side, and results of the last assembly there.
  type :: control_points_t
    real(wp), allocatable :: multiplier(:)   !! (n) pressure of the augmentation [F/L^2]
    real(wp), allocatable :: multiplier_step(:) !! (n) multiplier at the start of the step
    real(wp), allocatable :: pressure(:)     !! (n) pressure of the control point itself [F/L^2]
    real(wp), allocatable :: gap(:)          !! (n) weighted gap [L]; huge where there is no overlap
  end type control_points_t

  !> MORTAR: the points at which friction acted in the previous step. The points of new cells get
  !! values that are interpolated from these points in the same element.
  type :: friction_points_t
    integer, allocatable :: elem(:)          !! (n) ascending
    real(wp), allocatable :: xi(:, :)        !! (2, n)
    real(wp), allocatable :: elastic(:, :)   !! (3, n) see friction_law_i [L]
    real(wp), allocatable :: slip_rate(:)    !! (n) rate of slip; 0: no slip [L/T]
    real(wp), allocatable :: limit(:)        !! (n) friction at which the point slips [F/L^2]
  end type friction_points_t

  !> History of one contact.
  type :: contact_state_t
    type(contact_points_t) :: side(2)
    type(control_points_t) :: control(2)
    type(friction_points_t) :: rubbed(2)
    !> MORTAR with friction: positions at which the cells of the previous step were cut, three
    !! values for each node of each element of side 1, and then of side 2 [L]. Not allocated before
    !! friction has acted in a step.
    real(wp), allocatable :: last_cut(:)
    !> At the end of the previous step: energy of the pressure and elastic energy of friction at the
    !! points of each side, and the work of all slip so far [F L].
    real(wp) :: pressed(2) = 0.0_wp, sheared(2) = 0.0_wp, dissipated = 0.0_wp
    !> At the end of the previous step, for each side: integral of the friction limit [F].
    real(wp) :: limit_force(2) = 0.0_wp
    !> MORTAR: force on each side and its moment about the origin, from the last assembly [F], [F L]
    real(wp) :: force(3, 2) = 0.0_wp, moment(3, 2) = 0.0_wp
    real(wp) :: force_step(3, 2) = 0.0_wp, moment_step(3, 2) = 0.0_wp !! at the start of the step
    !> MORTAR: for each side that is integrated, the current area in contact and the parts of it
    !! that stick and slip [L^2]. Largest penetration of the corners of each side; with MORTAR that
    !! of its points and of the corners of both sides [L].
    real(wp) :: area(2) = 0.0_wp, sticks(2) = 0.0_wp, slips(2) = 0.0_wp, penetration(2) = 0.0_wp
    logical :: depth_warned = .false.        !! warning about points deeper than `depth` issued
    !> Largest value over all steps of |F1 + F2|, where F1 and F2 are the forces on the two sides,
    !! relative to the larger force [-].
    real(wp) :: balance = 0.0_wp
    !> Largest penetration over all steps, relative to the width of an element or the thickness,
    !! whichever is smaller [-].
    real(wp) :: deepest = 0.0_wp
    real(wp) :: largest_force = 0.0_wp       !! largest force over all steps [F]
    logical :: touched = .false.             !! the contact has closed in some step
    !> If it has not: the smallest gap so far [L], the point where it occurs, and its step.
    real(wp) :: nearest = huge(1.0_wp), x_nearest(3) = 0.0_wp
    integer :: nearest_step = 0              !! 0: before the first step
    logical :: balance_warned = .false., penetration_warned = .false., friction_warned = .false.
    logical :: break_warned = .false.        !! warned about bonds that break within a step
    !> At the end of the previous step: part of the force that acts between faces which are not
    !! opposite each other [-].
    real(wp) :: oblique = 0.0_wp
    logical :: oblique_warned = .false.      !! warned about a body that stands on its edge
    !> Width of the touching region at the largest force so far, relative to an element
    !! (contact_patch); negative: not measured.
    real(wp) :: patch = -1.0_wp
  end type contact_state_t

contains

  !> Is a side integrated? If so, it has integration points of its own.
  pure logical function is_integrated(contact, k)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k

    is_integrated = .not. (contact%side(k)%rigid .or. (contact%self .and. k == 2))
  end function is_integrated

  !> How far a bond is open: 0 if it is closed, 1 from the opening on at which it is released. The
  !! openings of the two modes count relative to their own values, because an opening of one mode
  !! that has reached its value leaves no traction in the other mode either.
  pure real(wp) function release_of(contact, opening)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: opening(2)       !! normal and shear, or the whole opening and 0 [L]

    release_of = norm2(opening/contact%released)
  end function release_of

  !> Is bonded point i released? With damage, the largest openings so far decide, because a bond
  !! that closes again does not heal; a reversible law stores its current opening.
  pure logical function is_released(contact, points, i)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i

    is_released = release_of(contact, points%past(LARGEST_OPENINGS, i)) >= 1.0_wp
  end function is_released

  !> The options of a contact that the log shows after the normal law.
  function option_text(contact) result(text)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text

    text = ''
    associate (d => contact%normal%prop(SMOOTHING))
      if (d > 0.0_wp) text = text//', smoothed up to a penetration of '//to_text(d)
    end associate
    if (contact%on_pair) text = text//', between bonded points and their partners until release'
    if (contact%taper > 0.0_wp) text = text//', tapered towards edges over ' &
                                       //to_text(contact%taper)//' of the width of an element'
    if (contact%scheme == BALANCED) text = text//', balanced'
    if (contact%scheme == MORTAR) text = text//', mortar'
  end function option_text

end module contact_pair
