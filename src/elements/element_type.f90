!> An element type as a row of the table of elements: its data and the interfaces of its procedures.
module element_type
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use material_type, only: material_t, NB
  implicit none
  private
  public :: element_t, cell_t, topology_t, rule_t, form_report_t
  public :: element_form_i, element_batch_i
  public :: NB

  !> One variant of an element type: its degrees and, for splines, its Bezier extraction and
  !! weights.
  type :: cell_t
    integer :: degree(3) = 1            !! degrees in the element's own directions
    !> Extraction operator of each direction, (p+1, p+1): N = C B; not allocated for Lagrange
    !! functions.
    real(wp), allocatable :: c1(:, :)   !! direction 1
    real(wp), allocatable :: c2(:, :)   !! direction 2
    real(wp), allocatable :: c3(:, :)   !! direction 3 (trivariate elements only)
    !> Extraction operator of a surface that is not a tensor product, which replaces c1 and c2:
    !! (functions, Bernstein polynomials of directions 1 and 2), with any number of functions.
    real(wp), allocatable :: c(:, :)
    real(wp), allocatable :: w(:)       !! weights of the control points; not allocated: all one
  end type cell_t

  !> Integration rule on the parent cell.
  type :: rule_t
    integer :: nq = 0
    real(wp), allocatable :: xi(:, :)  !! (3, nq)
    real(wp), allocatable :: wgt(:)    !! (nq)
  end type rule_t

  !> Faces of one variant of an element type (cell_t), and how VTK draws it. The faces of a
  !! hexahedral parent cell are numbered xi-, xi+, eta-, eta+, zeta-, zeta+ (1 to 6).
  type :: topology_t
    integer :: nen = 0
    integer :: nface = 0
    integer, allocatable :: first(:)  !! (nface+1) where a face's nodes begin in `node`
    integer, allocatable :: node(:)   !! local nodes of the faces, one face after another
    integer :: vtk = 0                !! VTK cell type (12 Q1, 79 Bezier, 10 tetrahedron)
    integer, allocatable :: vtk_node(:) !! local node of each VTK point; unset in spline cells
    !> What readers of mesh files need to know about elements with deck_nodes > 0; unset in other
    !! elements.
    character(12) :: shape = ''         !! tetrahedron, pyramid, wedge or hexahedron
    integer, allocatable :: corner(:)   !! local nodes at the corners
    real(wp), allocatable :: xr(:, :)   !! (3, nen) node positions in the reference element [-]
    integer :: gmsh = 0                 !! element type in Gmsh; 0: there is none
    integer, allocatable :: gmsh_node(:) !! local node of each Gmsh node; not allocated: same order
  end type topology_t

  !> Outcome of `form` for one element.
  type :: form_report_t
    logical :: ok = .true.          !! .false.: inverted element or singular condensation
    integer :: negative = 0         !! number of negative eigenvalues of K_aa (element_form_i)
    real(wp) :: enhanced = 0.0_wp   !! |r_a . K_aa^-1 r_a|: energy of the enhanced residual [F L]
  end type form_report_t

  !> An element type. It has no state; properties and history are passed as arrays.
  type :: element_t
    character(16) :: name = ''       !! e.g. Q1E9
    character(100) :: source = ''    !! formulation and reference, for the log
    logical :: spline = .false.      !! functions need Bezier extraction (cell%c1, ...)
    integer :: nmode = 0             !! number of enhanced modes, with three parameters each
    integer :: deck_nodes = 0        !! nodes in a record of ELEMents; 0: not available there
    integer :: degree = 0            !! degree of its faces; 0: it depends on the block
    !> Points of the rule for masses in each direction; 0: masses have the rule of the element.
    integer :: mass_points = 0
    integer :: deck_order(27) = 0    !! local node of each node of the deck; 0: in the same order
    procedure(element_rule_i), pointer, nopass :: rule => null()
    procedure(element_functions_i), pointer, nopass :: functions => null()
    procedure(element_topology_i), pointer, nopass :: topology => null()
    procedure(element_modes_i), pointer, nopass :: modes => null()
    !> A deformable element has at least one of these two procedures; if it has both, form_batch is
    !! used.
    procedure(element_form_i), pointer, nopass :: form => null()
    procedure(element_batch_i), pointer, nopass :: form_batch => null()
  end type element_t

  abstract interface
    !> Set the integration rule: q points in each of the directions xi and eta, and qz in zeta; 0
    !! means the default of the type.
    subroutine element_rule_i(cell, q, qz, rule)
      import :: cell_t, rule_t
      implicit none
      type(cell_t), intent(in) :: cell
      integer, intent(in) :: q, qz
      type(rule_t), intent(out) :: rule
    end subroutine element_rule_i

    !> Evaluate the functions and their parent derivatives at a point.
    pure subroutine element_functions_i(cell, xi, shp, dshp)
      import :: cell_t, wp
      implicit none
      type(cell_t), intent(in) :: cell
      real(wp), intent(in) :: xi(3)       !! in [-1,1]^3
      real(wp), intent(out) :: shp(:)     !! (nen)
      real(wp), intent(out) :: dshp(:, :) !! (3, nen)
    end subroutine element_functions_i

    subroutine element_topology_i(cell, topology)
      import :: cell_t, topology_t
      implicit none
      type(cell_t), intent(in) :: cell
      type(topology_t), intent(out) :: topology
    end subroutine element_topology_i

    !> Evaluate the parent covectors of the enhanced modes; their mean over the parent cell is zero.
    pure subroutine element_modes_i(xi, mode)
      import :: wp
      implicit none
      real(wp), intent(in) :: xi(3)
      real(wp), intent(out) :: mode(:, :) !! (3, nmode)
    end subroutine element_modes_i

    !> Compute residual and consistent tangent of one element, with its enhanced modes condensed.
    !!
    !! The history of an element with nmode > 0 has the length history_length(nen, nmode) of
    !! solid_form. It contains three results for the displacements u - du: the enhanced parameters
    !! a, the vector m = K_aa^-1 r_a, and the matrix L = K_aa^-1 K_au, where r_a is the residual of
    !! the parameters, and K_aa and K_au are its derivatives with respect to a and u. The kernel
    !! sets a_new = a - scale*m - L du, computes residual and tangent, and returns a_new, m_new and
    !! L_new.
    pure subroutine element_form_i(basis, material, prop, xr, u, du, scale, h_old, h_new, &
                                   r, k, report)
      import :: basis_t, material_t, form_report_t, wp
      implicit none
      type(basis_t), intent(in) :: basis
      type(material_t), intent(in) :: material
      real(wp), intent(in) :: prop(:)     !! (nprop) properties of the material
      real(wp), intent(in) :: xr(:, :)    !! (3, nen) reference positions [L]
      real(wp), intent(in) :: u(:, :)     !! (3, nen) trial displacements [L]
      real(wp), intent(in) :: du(:, :)    !! (3, nen) u minus the displacements of h_old
      !> Fraction of the Newton increment that du contains: 0 at the start of a step, 1 for a full
      !! increment, less in a line search.
      real(wp), intent(in) :: scale
      real(wp), intent(in) :: h_old(:)    !! (nhist)
      real(wp), intent(out) :: h_new(:)   !! (nhist)
      real(wp), intent(out) :: r(:, :)    !! (3, nen) internal force [F]
      real(wp), intent(out) :: k(:, :)    !! (3*nen, 3*nen) dr/du [F/L]
      type(form_report_t), intent(out) :: report
    end subroutine element_form_i

    !> Do the same as element_form_i for NB elements of one class; the first index is the element.
    pure subroutine element_batch_i(basis, material, prop, xr, u, du, scale, h_old, h_new, &
                                    r, k, report)
      import :: basis_t, material_t, form_report_t, wp, NB
      implicit none
      type(basis_t), intent(in) :: basis
      type(material_t), intent(in) :: material
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: xr(:, :, :)    !! (NB, 3, nen)
      real(wp), intent(in) :: u(:, :, :)
      real(wp), intent(in) :: du(:, :, :)
      real(wp), intent(in) :: scale
      real(wp), intent(in) :: h_old(:, :)    !! (nhist, NB)
      real(wp), intent(out) :: h_new(:, :)
      real(wp), intent(out) :: r(:, :, :)    !! (NB, 3, nen)
      !> (NB, 3, 3, nen, nen): dr(i,a)/du(j,b) is in (:, i, j, a, b), which is set for a <= b; the
      !! other blocks are their transposes.
      real(wp), intent(out) :: k(:, :, :, :, :)
      type(form_report_t), intent(out) :: report(NB)
    end subroutine element_batch_i
  end interface

end module element_type
