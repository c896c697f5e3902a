!> Contacts as they are given: two surfaces, laws, integration points; and the points' history.
module contact_pair
  use base_kinds, only: wp
  use base_error, only: place_t
  use contact_type, only: contact_law_t, MAX_LAW_PROP
  implicit none
  private
  public :: contact_t, surface_t, surface_basis_t, contact_points_t, contact_state_t, bond_t, &
            edge_part_t

  !> Functions of surface elements of one basis: N = C B with Bernstein polynomials B on [-1,1]^2,
  !! the first direction fastest. Facets and Lagrange patches are written this way too.
  type :: surface_basis_t
    integer :: degree(2) = 1
    integer :: nsf = 0                       !! functions
    real(wp), allocatable :: c(:, :)         !! (nsf, nb) extraction, nb = (degree+1)(degree+1)
    real(wp), allocatable :: shp(:, :)       !! (nsf, nq) at the integration points, without weights
    real(wp), allocatable :: dshp(:, :, :)   !! (2, nsf, nq)
  end type surface_basis_t

  !> A part of an edge and what is behind it: T-junctions.
  type :: edge_part_t
    real(wp) :: own(2) = 0.0_wp              !! parameters of the edge, rising
    integer :: elem = 0, edge = 0            !! behind it
    real(wp) :: other(2) = 0.0_wp            !! its parameters at own(1) and own(2)
  end type edge_part_t

  !> One side: elements with outward normal a_1 x a_2, and how they hang together.
  !! Edges 1 to 4 of an element: xi-, xi+, eta-, eta+. Corners 1 to 4: (-,-) (+,-) (-,+) (+,+).
  type :: surface_t
    character(:), allocatable :: name        !! as in the deck: hemi 3-
    logical :: rigid = .false.               !! its nodes are prescribed; not integrated
    real(wp) :: thickness = 0.0_wp           !! of its body behind it [L]; 0: unknown or rigid
    integer :: nelem = 0
    type(surface_basis_t), allocatable :: basis(:)
    integer, allocatable :: ibasis(:)         !! (nelem)
    integer, allocatable :: first(:)         !! (nelem+1) where an element's nodes begin in `node`
    integer, allocatable :: node(:)          !! nodes and control points of all elements
    real(wp), allocatable :: w(:)            !! (size(node)) weights; not allocated: all one
    integer, allocatable :: block(:), elem(:), face(:) !! (nelem) the element face it is
    integer, allocatable :: neighbour(:, :) !! (4, nelem) element behind an edge; 0: the outer
    !! boundary
    integer, allocatable :: edge(:, :) !! (4, nelem) edge there; negative: it runs the other way
    !> Parts of edge k of element e from part_first(4(e-1)+k) on, where an edge meets several ones
    !! or a part of one; `neighbour` is one of them then. Not allocated: there are none.
    integer, allocatable :: part_first(:)    !! (4*nelem+1)
    type(edge_part_t), allocatable :: part(:)
    logical, allocatable :: point(:, :) !! (4, nelem) edge is a point (prisms); not allocated: none
    !! is
    integer, allocatable :: vertex(:, :)     !! (4, nelem) vertex at each corner
    integer, allocatable :: ring_first(:)    !! (nvertex+1) where the elements round a vertex begin
    integer, allocatable :: ring_elem(:)     !! elements round the vertices
    integer, allocatable :: ring_corner(:)   !! and their corners there
    logical, allocatable :: outer(:)         !! (nvertex) the vertex lies on the outer boundary
  end type surface_t

  !> Where reference points are bonded: the half space that a normal points into, or a box.
  type :: bond_t
    logical :: is_except = .false.           !! they are not bonded there
    logical :: is_box = .false.
    real(wp) :: a(3) = 0.0_wp                !! point of the plane, or low corner [L]
    real(wp) :: b(3) = 0.0_wp                !! unit normal [-], or high corner [L]
  end type bond_t

  !> CONTact of the deck.
  type :: contact_t
    character(:), allocatable :: name
    type(place_t) :: place
    type(surface_t) :: side(2)
    type(contact_law_t) :: normal
    real(wp) :: normal_prop(MAX_LAW_PROP) = 0.0_wp
    !> PAIR: the penalty of bonded points acts between point and partner until the bond is released.
    logical :: on_pair = .false.
    !> BORDer: width, relative to an element, over which the pressure fades to a surface's border.
    real(wp) :: border = 0.0_wp
    !> BALAnced: every point loads both surfaces, with half of its traction each.
    logical :: balanced = .false.
    logical :: has_friction = .false.
    type(contact_law_t) :: friction
    real(wp) :: friction_prop(MAX_LAW_PROP) = 0.0_wp
    logical :: has_after = .false.           !! AFTEr was said
    real(wp) :: after = 0.0_wp               !! friction acts in steps that start then or later
    logical :: has_cohesive = .false.
    type(contact_law_t) :: cohesive
    real(wp) :: cohesive_prop(MAX_LAW_PROP) = 0.0_wp
    real(wp) :: tau = 0.0_wp                 !! time of VISCous [T]; 0: none
    real(wp) :: released = 0.0_wp            !! opening from which a bond counts as released [L]
    type(bond_t), allocatable :: bond(:)     !! all but the excepted hold; none: everywhere
    real(wp) :: bond_gap = -1.0_wp           !! GAP [L]; negative: 1e-3 of the element
    !> How the penalty of NORMal was found; not allocated: the deck gives it.
    character(:), allocatable :: auto
    logical :: default_depth = .false.       !! the deck gives no DEPTh
    real(wp) :: depth = 0.0_wp               !! a deeper penetration is no contact [L]
    integer :: nq = 0                        !! integration points of a surface element
    integer :: nplain = 0                    !! of them, those of the plain rule (subcell_quadrature)
    integer :: ncell = 1                     !! cells a direction of elements that are cut
    real(wp), allocatable :: xi(:, :)        !! (2, nq)
    real(wp), allocatable :: wgt(:)          !! (nq)
  end type contact_t

  !> History of the integration points of one side. Point q of element e stands at (e-1)*nq + q.
  type :: contact_points_t
    !> The point's foot on the other surface: where its next projection starts. Element 0: none.
    integer, allocatable :: foot(:)          !! (np)
    real(wp), allocatable :: foot_xi(:, :)   !! (2, np)
    integer, allocatable :: foot_step(:)     !! (np) the same at the start of the step
    real(wp), allocatable :: foot_xi_step(:, :)
    !> The stored sliding point on the other surface; moved only when a step is accepted. 0: none.
    integer, allocatable :: slide(:)         !! (np)
    real(wp), allocatable :: slide_xi(:, :)  !! (2, np)
    real(wp), allocatable :: multiplier(:)   !! (np) pressure of the augmentation [F/L^2]
    real(wp), allocatable :: multiplier_step(:) !! (np) at the start of the step
    !> `state` when the last step ended: points that slipped begin with the tangent of slip.
    integer, allocatable :: state_step(:)    !! (np)
    real(wp), allocatable :: slip_rate(:)    !! (np) slip over time in the last step [L/T]
    real(wp) :: dt = 0.0_wp                  !! of the step under way [T]; 0: no time
    !> Beside the other surface, and not far above it, when the last step ended: what comes from
    !! there enters the body through its side, and is not pressed out through the face.
    logical, allocatable :: aside(:)         !! (np)
    logical :: fresh = .false.               !! no sweep was made in this step yet
    logical, allocatable :: cut(:)           !! (nelem) the points behind the plain rule act
    !> Cohesive partner on the other surface, found in the reference configuration. 0: not bonded.
    integer, allocatable :: bond(:)          !! (np)
    real(wp), allocatable :: bond_xi(:, :)   !! (2, np)
    real(wp), allocatable :: area0(:)        !! (np) reference area the point stands for [L^2]
    real(wp), allocatable :: past(:, :)      !! (MAX_PAST, np) what the cohesive law remembers
    real(wp), allocatable :: past_step(:, :) !! (MAX_PAST, np) at the start of the step
    real(wp), allocatable :: opening(:)      !! (np) of now: distance to the partner [L]
    real(wp), allocatable :: opening_step(:) !! (np) at the start of the step
    real(wp), allocatable :: energy(:, :)    !! (3, np) stored, spent, viscous per area0 [F/L]
    real(wp), allocatable :: pull(:, :)      !! (3, np) traction of the bond on area0 [F/L^2]
    !> What the last sweep found.
    integer, allocatable :: state(:)         !! (np) OPEN, STICK, SLIP, TOUCH
    real(wp), allocatable :: gap(:)          !! (np) [L]; huge where there is no foot
    real(wp), allocatable :: pressure(:)     !! (np) [F/L^2]
    real(wp), allocatable :: traction(:, :)  !! (3, np) on this side [F/L^2]
    !> Shares of `traction` [F/L^2]: of friction, and of cohesion on the reference area.
    real(wp), allocatable :: friction(:, :), cohesion(:, :) !! (3, np)
    real(wp), allocatable :: elastic(:, :) !! (3, np) [L] part of the tangential way that is not
    !! slip
    real(wp), allocatable :: slip(:)         !! (np) the rest of it [L]
    real(wp), allocatable :: area(:)         !! (np) current area the point stands for [L^2]
  end type contact_points_t

  !> One contact's history.
  type :: contact_state_t
    type(contact_points_t) :: side(2)
    logical :: passed = .false.              !! the user was told that points passed depth
  end type contact_state_t

end module contact_pair
