!> Work space of a contact with the mortar scheme, and the functions of its control points.
module mortar_type
  use base_kinds, only: wp
  use contact_cells, only: cells_t
  use contact_pair, only: contact_t, surface_t
  use contact_work, only: element_functions, work_t
  use projection_search, only: grid_t
  use projection_type, only: shape_t
  use surface_geometry, only: update_shape
  implicit none
  private
  public :: new_mortar, control_functions, functions_at, number_at, size_of_element

  !> The nodes that one control point couples, in any order: the pressure of the control point
  !! varies with the positions of these nodes and acts on them.
  type :: node_list_t
    integer, allocatable :: node(:)
  end type node_list_t

  !> Work space of one side.
  type, public :: mortar_side_t
    type(cells_t) :: cells
    real(wp), allocatable :: shp(:, :)        !! (nk, n) functions of a point's own element
    real(wp), allocatable :: seen(:)          !! (n) `travel` at the last projection; negative: none
    real(wp), allocatable :: p(:), dp(:)      !! (n) pressure; derivative of its part with eps_1
    real(wp) :: no_gap = 0.0_wp               !! [L] points with a smaller gap just touch
    real(wp) :: no_slip = 0.0_wp              !! [L] points with a smaller gap stick
    integer, allocatable :: slide(:)          !! (n) element of the sliding point; 0: not sought
    !! yet, negative: there is none
    real(wp), allocatable :: slide_xi(:, :)   !! (2, n)
    real(wp), allocatable :: slide_shp(:, :)  !! (nl, n) functions at the sliding point
    !> (n) Expected rate of slip [L/T]; negative: none.
    real(wp), allocatable :: ahead(:)
    real(wp), allocatable :: limit(:)         !! (n) friction limit at the start of the step [F/L^2]
    real(wp), allocatable :: friction(:, :)   !! (3, n) traction of friction [F/L^2]
    real(wp), allocatable :: elastic(:, :)    !! (3, n) see friction_law_i [L]
    real(wp), allocatable :: slip(:)          !! (n) [L]
    integer, allocatable :: state(:)          !! (n) OPEN, STICK, SLIP, TOUCH
    real(wp), allocatable :: q(:), dq(:)      !! (ncontrol) pressure and its derivative
    real(wp), allocatable :: a(:)             !! (ncontrol) reference area of the overlap [L^2]
    real(wp), allocatable :: volume(:)        !! (ncontrol) weighted gap, see mortar_control [L^3]
    integer, allocatable :: round_first(:)    !! (ncontrol+1) position in `round`
    integer, allocatable :: round(:)          !! elements around the control points
    type(node_list_t), allocatable :: known(:) !! (ncontrol) couplings of the current pattern
  end type mortar_side_t

  !> Scratch space for the points of one element that carry a pressure. nk and nl are the numbers of
  !! nodes of the element and of the one that it faces, and nd = 3 (nk + nl).
  type, public :: kernel_t
    integer, allocatable :: point(:)           !! (n) points, sorted by slot
    integer, allocatable :: slot(:)            !! (n) slot of the element that the point faces
    integer, allocatable :: slide_slot(:)      !! (n) slot of its sliding point's element; 0: none
    real(wp), allocatable :: xe(:, :)          !! (3, nk) positions of its own nodes [L]
    !> For the m points that face one element; some of them slide on another element:
    real(wp), allocatable :: own(:)            !! (nk, m) own functions
    real(wp), allocatable :: shp(:)            !! (nl, m) functions at the projections
    real(wp), allocatable :: slope(:)          !! (nl, 2, m, 3) dM/dxi times traction [F/L^2]
    real(wp), allocatable :: dt(:)             !! (nd, 3, m) w dt/dx_d, see mortar_kernel [F/L]
    real(wp), allocatable :: dxi(:)            !! (nd, 2, m) w dxi/dx_d [L]
    real(wp), allocatable :: ds(:, :, :)       !! (3, 3, m) w dt/dx_s at the sliding point x_s [F/L]
    real(wp), allocatable :: k(:)              !! (max(nk, nl), nd, 3) a product [F/L]
  end type kernel_t

  !> Work space of the threads that form elements of one side.
  type, public :: crew_t
    type(kernel_t), allocatable :: kernel(:)  !! (nthread)
    type(work_t), allocatable :: work(:)      !! (nthread)
  end type crew_t

  !> Work space of one contact.
  type, public :: mortar_t
    integer :: step = -1                      !! step of the last projection
    integer :: cuts = 0                       !! number of cuts since the iteration settled
    integer :: slow_cuts = 0                  !! the same, including those that do not count there
    real(wp) :: increment = 0.0_wp            !! smallest motion before one of these cuts [L]
    logical :: stale = .false.                !! surfaces have moved since the last cut, and the
    !! cells will be cut again
    logical :: keeps = .false.                !! the step keeps the cells of the previous step
    logical :: patient = .true.               !! a slow iteration may cut cells MOST_SLOW_CUTS times
    logical :: follows = .false.              !! with friction, the cells were cut at the last
    !! iterate because the iteration has settled
    integer :: iterate = 0                    !! evaluations since the step began, without trials
    real(wp) :: least = 0.0_wp                !! size of the smallest facet [L]
    real(wp), allocatable :: x_cut(:, :)      !! (3, nnode) positions at which cells were cut [L]
    real(wp) :: travel = 0.0_wp               !! bound on the motion since the last cut [L]
    real(wp), allocatable :: x_last(:, :)     !! (3, nnode) positions at the last projection [L]
    real(wp), allocatable :: x_iterate(:, :)  !! (3, nnode) last iterate, without trials [L]
    logical :: slides = .false.               !! friction acts
    logical :: fresh = .false.                !! forces of this step have not been formed yet
    type(shape_t) :: reference(2)
    type(shape_t) :: start(2)                 !! surfaces at the start of the step, with friction
    type(grid_t) :: start_grid(2)
    type(mortar_side_t) :: side(2)
    type(crew_t) :: crew(2)                   !! for the elements of each side
  end type mortar_t

contains

  !> Allocate and initialise the work space of a contact.
  subroutine new_mortar(contact, xr, mortar)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)          !! (3, nnode) reference positions [L]
    type(mortar_t), intent(out) :: mortar
    integer :: i, k, n

    do k = 1, 2
      call update_shape(contact%side(k), xr, mortar%reference(k))
      n = contact%side(k)%ncontrol
      associate (side => mortar%side(k))
        allocate (side%q(n), side%dq(n), side%a(n), side%volume(n), source=0.0_wp)
        allocate (side%known(n))
        do i = 1, n
          allocate (side%known(i)%node(0))
        end do
        call find_rounds(contact%side(k), side)
      end associate
    end do
  end subroutine new_mortar

  !> Find the elements around each control point.
  subroutine find_rounds(surface, side)
    type(surface_t), intent(in) :: surface
    type(mortar_side_t), intent(inout) :: side
    integer :: a, e, i, pass
    integer :: last(surface%ncontrol), n(surface%ncontrol)

    n = 0
    do pass = 1, 2 ! count, then enter
      last = 0
      do e = 1, surface%nelem
        do i = surface%control_first(e), surface%control_first(e + 1) - 1
          a = surface%control(i)
          if (last(a) == e) cycle
          last(a) = e
          if (pass == 2) side%round(side%round_first(a) + n(a)) = e
          n(a) = n(a) + 1
        end do
      end do
      if (pass == 2) exit
      allocate (side%round_first(surface%ncontrol + 1), side%round(sum(n)))
      side%round_first(1) = 1
      do a = 1, surface%ncontrol
        side%round_first(a + 1) = side%round_first(a) + n(a)
      end do
      n = 0
    end do
  end subroutine find_rounds

  !> Functions of the control points of an element at xi; `shp` are those of its nodes.
  pure subroutine control_functions(surface, xi, shp, psi)
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: xi(2), shp(:)
    real(wp), intent(out) :: psi(:)

    if (surface%hats) then
      psi(:4) = 0.25_wp*[(1 - xi(1))*(1 - xi(2)), (1 + xi(1))*(1 - xi(2)), &
                         (1 - xi(1))*(1 + xi(2)), (1 + xi(1))*(1 + xi(2))]
    else
      psi(:size(shp)) = shp
    end if
  end subroutine control_functions

  !> Functions of the control points of element e at xi.
  pure subroutine functions_at(surface, e, xi, psi)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: psi(:)
    real(wp) :: shp(size(psi)), dshp(2, size(psi))
    integer :: n

    n = surface%first(e + 1) - surface%first(e)
    call element_functions(surface, e, xi, shp(:n), dshp(:, :n))
    call control_functions(surface, xi, shp(:n), psi)
  end subroutine functions_at

  !> Largest number of functions in an element of a surface, for its nodes or its control points.
  pure integer function size_of_element(surface) result(n)
    type(surface_t), intent(in) :: surface

    n = max(4, maxval(surface%basis%nsf))
  end function size_of_element

  !> Number of control points of element e.
  pure integer function number_at(surface, e) result(n)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e

    n = surface%control_first(e + 1) - surface%control_first(e)
  end function number_at

end module mortar_type
