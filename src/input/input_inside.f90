!> Finds elements that lie within other elements of the same body, or of a body that common nodes
!! join to theirs, at the start or at the end of a run. The material counts twice there, or parts
!! have passed through each other, and nothing else in the results shows this; input_overlap finds
!! other bodies that overlap.
!!
!! An element lies within another one if its middle does, clearly. The middles of neighbours are at
!! least half an element apart from each other, so neighbours are never meant, even if they are
!! curved. Parts between which a contact acts may overlap.
module input_inside
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use contact_pair, only: contact_t
  use input_doubts, only: member_t, list_members, element_text, place_of, NEAR
  use input_draft, only: draft_t
  use input_locate, only: is_within
  use input_overlap, only: find_centre
  use mesh, only: mesh_t
  use rigid_modes, only: find_pieces
  implicit none
  private
  public :: warn_inside, warn_moved_inside

  !> Parent coordinates of a point that is clearly within an element are at most this large.
  real(wp), parameter :: CLEARLY = 0.9_wp
  integer, parameter :: MOST_STEPS = 60 !! largest number of times the width of cells decreases

  !> Elements, and cells of equal size that list the elements whose middle they contain.
  type :: grid_t
    type(member_t), allocatable :: list(:)
    real(wp) :: low(3) = 0.0_wp, width(3) = 1.0_wp !! origin of the grid, size of a cell [L]
    integer :: n(3) = 1                            !! numbers of cells
    integer, allocatable :: head(:, :, :), next(:)
  end type grid_t

contains

  !> Warn if elements lie within other elements at the start.
  subroutine warn_inside(draft, mesh, contact)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    type(member_t), allocatable :: list(:)
    integer, allocatable :: host(:)
    integer :: i, pair(2)

    call find_inside(mesh, contact, [(.true., i=1, size(contact))], .false., list, host)
    if (.not. any(host > 0)) return
    pair = first_pair(host)
    call warn(overlap_text(mesh, list, host, ''), place_of(draft, mesh, list(pair(1))), &
              'two parts occupy the same place, where the material counts twice or nothing joins ' &
              //'them: check their positions and sizes')
  end subroutine warn_inside

  !> At the end of a run, warn if elements lie within others that did not at the start: parts of one
  !! body, or of bodies that are joined somewhere, have passed through each other.
  subroutine warn_moved_inside(mesh, contact, acted, x)
    type(mesh_t), intent(inout) :: mesh    !! unchanged on return
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: acted(:)        !! (size(contact)) the contact has closed in some step
    real(wp), intent(in) :: x(:, :)        !! (3, nnode) current positions [L]
    type(member_t), allocatable :: list(:)
    integer, allocatable :: host(:), before(:)
    real(wp), allocatable :: xr(:, :)

    if (.not. allocated(mesh%xr)) return
    xr = mesh%xr
    mesh%xr = x
    call find_inside(mesh, contact, acted, .true., list, host)
    mesh%xr = xr
    if (.not. any(host > 0)) return
    call find_inside(mesh, contact, acted, .true., list, before)
    where (before > 0) host = 0
    if (.not. any(host > 0)) return
    call warn(overlap_text(mesh, list, host, ' at the end'), hint='parts of the mesh have ' &
              //'passed through each other: they act on each other only through CONTact or TIE; ' &
              //'name all faces that meet in a CONTact')
  end subroutine warn_moved_inside

  !> The first element that lies within another one, and the latter; the later of them comes first.
  pure function first_pair(host) result(pair)
    integer, intent(in) :: host(:)         !! (elements) see find_inside
    integer :: pair(2)
    integer :: a

    a = findloc(host > 0, .true., 1)
    pair = [max(a, host(a)), min(a, host(a))]
  end function first_pair

  !> Name the first pair of elements that overlap, and the number of elements within others.
  function overlap_text(mesh, list, host, when) result(text)
    type(mesh_t), intent(in) :: mesh
    type(member_t), intent(in) :: list(:)
    integer, intent(in) :: host(:)         !! (elements) see find_inside
    character(*), intent(in) :: when
    character(:), allocatable :: text
    integer :: pair(2)

    pair = first_pair(host)
    text = element_text(mesh, list(pair(1)))//' and '//element_text(mesh, list(pair(2))) &
           //' overlap'//when
    if (count(host > 0) > 1) text = text//' (the middles of '//to_text(count(host > 0)) &
                                    //' elements lie within others)'
  end function overlap_text

  !> Find the elements that lie within others.
  subroutine find_inside(mesh, contact, acts, twice, list, host)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: acts(:)         !! (size(contact)) contacts that count
    logical, intent(in) :: twice           !! include elements in the same place (check_twice)
    type(member_t), allocatable, intent(out) :: list(:) !! all elements
    integer, allocatable, intent(out) :: host(:) !! (elements) the element around each one; 0: none
    type(grid_t) :: grid
    integer, allocatable :: piece(:)       ! (nnode)
    real(wp) :: low(3), high(3)
    logical :: may
    integer :: a, b, i, j, k, from(3), to(3)

    call list_members(mesh, grid%list)
    allocate (host(size(grid%list)), source=0)
    if (size(grid%list) > 1) then
      call fill_grid(mesh, grid)
      call find_pieces(mesh, piece)
    end if
    do b = 1, merge(size(grid%list), 0, size(grid%list) > 1)
      associate (node => mesh%block(grid%list(b)%block)%conn(:, grid%list(b)%elem))
        low = minval(mesh%xr(:, node), 2)
        high = maxval(mesh%xr(:, node), 2)
      end associate
      from = cell_of(grid, low)
      to = cell_of(grid, high)
      do k = from(3), to(3)
        do j = from(2), to(2)
          do i = from(1), to(1)
            a = grid%head(i, j, k)
            do while (a > 0)
              associate (x => grid%list(a)%centre)
                may = a /= b .and. host(a) == 0 .and. all(x > low .and. x < high)
              end associate
              if (may .and. .not. twice) may = .not. in_same_place(grid%list(a), grid%list(b))
              if (may) may = lies_within(mesh, contact, acts, piece, grid%list(a), grid%list(b))
              if (may) host(a) = b
              a = grid%next(a)
            end do
          end do
        end do
      end do
    end do
    call move_alloc(grid%list, list)
  end subroutine find_inside

  !> Find the middles of all elements, and sort these into cells, about one in each.
  subroutine fill_grid(mesh, grid)
    type(mesh_t), intent(in) :: mesh
    type(grid_t), intent(inout) :: grid
    real(wp) :: high(3), side
    integer :: a, at(3)

    grid%low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do a = 1, size(grid%list)
      call find_centre(mesh, grid%list(a)%block, grid%list(a)%elem, grid%list(a)%centre)
      grid%low = min(grid%low, grid%list(a)%centre)
      high = max(high, grid%list(a)%centre)
    end do
    side = max(maxval(high - grid%low), tiny(1.0_wp)*1.0e3_wp)
    do a = 1, MOST_STEPS ! smaller cells, until there are enough
      grid%n = int(min((high - grid%low)/side, 1.0e6_wp)) + 1
      if (2*product(real(grid%n, wp)) > size(grid%list)) exit
      side = 0.8_wp*side
    end do
    grid%width = side
    allocate (grid%head(grid%n(1), grid%n(2), grid%n(3)), source=0)
    allocate (grid%next(size(grid%list)), source=0)
    do a = size(grid%list), 1, -1
      at = cell_of(grid, grid%list(a)%centre)
      grid%next(a) = grid%head(at(1), at(2), at(3))
      grid%head(at(1), at(2), at(3)) = a
    end do
  end subroutine fill_grid

  pure function cell_of(grid, x) result(at)
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    integer :: at(3)

    at = int(max(0.0_wp, min((x - grid%low)/grid%width, grid%n - 1.0_wp))) + 1
  end function cell_of

  pure logical function in_same_place(a, b) result(yes)
    type(member_t), intent(in) :: a, b

    yes = norm2(a%centre - b%centre) <= NEAR*a%size .and. abs(a%size - b%size) <= NEAR*a%size
  end function in_same_place

  !> Does the middle of element a lie clearly within element b, without a contact between them?
  logical function lies_within(mesh, contact, acts, piece, a, b) result(yes)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: acts(:)    !! (size(contact))
    integer, intent(in) :: piece(:)   !! (nnode)
    type(member_t), intent(in) :: a, b
    real(wp) :: d(3)
    integer :: body(2), part(2)

    yes = .false.
    body = mesh%block([a%block, b%block])%body
    part = [piece(mesh%block(a%block)%conn(1, a%elem)), piece(mesh%block(b%block)%conn(1, b%elem))]
    if (body(1) /= body(2) .and. part(1) /= part(2)) return
    associate (xb => mesh%xr(:, mesh%block(b%block)%conn(:, b%elem)))
      d = a%centre - b%centre
      if (dot_product(d, a%centre) >= maxval(matmul(d, xb)) .and. norm2(d) > 0.0_wp) return
    end associate
    if (.not. is_within(mesh, b%block, b%elem, a%centre, CLEARLY)) return
    yes = .not. in_contact(mesh, contact, acts, piece, body, part)
  end function lies_within

  !> Does a contact act between two pieces, each of one body?
  pure logical function in_contact(mesh, contact, acts, piece, body, part) result(yes)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: acts(:)            !! (size(contact))
    integer, intent(in) :: piece(:)           !! (nnode)
    integer, intent(in) :: body(2), part(2)
    logical :: on(2, 2) ! part i is on side k
    integer :: c, e, i, k

    yes = .false.
    do c = 1, size(contact)
      if (.not. acts(c)) cycle
      on = .false.
      do k = 1, 2
        associate (side => contact(c)%side(k))
          do e = 1, side%nelem
            do i = 1, 2
              if (mesh%block(side%block(e))%body /= body(i)) cycle
              if (piece(side%node(side%first(e))) == part(i)) on(i, k) = .true.
            end do
          end do
        end associate
      end do
      yes = yes .or. (on(1, 1) .and. on(2, 2)) .or. (on(1, 2) .and. on(2, 1))
    end do
  end function in_contact

end module input_inside
