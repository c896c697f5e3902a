!> Finds elements that lie within other elements of the same body, or of a body that common nodes
!! join to theirs. The material counts twice there, and nothing else in the results shows this;
!! input_overlap finds other bodies that overlap.
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
  public :: warn_inside

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

  !> Warn if elements lie within other elements.
  subroutine warn_inside(draft, mesh, contact)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    type(grid_t) :: grid
    logical, allocatable :: within(:) ! (elements)
    integer, allocatable :: piece(:)  ! (nnode)
    character(:), allocatable :: text
    real(wp) :: low(3), high(3)
    integer :: a, b, i, j, k, from(3), to(3)
    integer :: first(2)               ! the first two elements that overlap

    first = 0
    call list_members(mesh, grid%list)
    if (size(grid%list) < 2) return
    call fill_grid(mesh, grid)
    call find_pieces(mesh, piece)
    allocate (within(size(grid%list)), source=.false.)
    do b = 1, size(grid%list)
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
                if (a /= b .and. .not. within(a) .and. all(x > low .and. x < high)) then
                  within(a) = lies_within(mesh, contact, piece, grid%list(a), grid%list(b))
                  if (within(a) .and. first(1) == 0) first = [a, b]
                end if
              end associate
              a = grid%next(a)
            end do
          end do
        end do
      end do
    end do
    if (first(1) == 0) return
    text = element_text(mesh, grid%list(first(1)))//' and ' &
           //element_text(mesh, grid%list(first(2)))//' overlap'
    if (count(within) > 1) text = text//' (the middles of '//to_text(count(within)) &
                                  //' elements lie within others)'
    call warn(text, place_of(draft, mesh, grid%list(first(1))), &
              'two parts occupy the same place, where the material counts twice or nothing joins ' &
              //'them: check their positions and sizes')
  end subroutine warn_inside

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

  !> Does the middle of element a lie clearly within element b, without a contact between them?
  !! Elements in the same place are left to check_twice.
  logical function lies_within(mesh, contact, piece, a, b) result(yes)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
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
      if (norm2(d) <= NEAR*a%size .and. abs(a%size - b%size) <= NEAR*a%size) return
    end associate
    if (.not. is_within(mesh, b%block, b%elem, a%centre, CLEARLY)) return
    yes = .not. in_contact(mesh, contact, piece, body, part)
  end function lies_within

  !> Does a contact act between two pieces, each of one body?
  pure logical function in_contact(mesh, contact, piece, body, part) result(yes)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: piece(:)           !! (nnode)
    integer, intent(in) :: body(2), part(2)
    logical :: on(2, 2) ! part i is on side k
    integer :: c, e, i, k

    yes = .false.
    do c = 1, size(contact)
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
