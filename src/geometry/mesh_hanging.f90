!> Faces between coarse and fine elements of a mesh with hanging nodes. The corners of the fine
!! faces are nodes of the coarse face or follow from them by constraints. Each of these faces
!! belongs to only one element, but none of them bounds the body.
module mesh_hanging
  use base_kinds, only: wp
  use base_sort, only: find, unique
  use constraint, only: constraint_t
  use mesh_faces, only: faces_t, measure_face
  use mesh_file, only: mesh_file_t
  implicit none
  private
  public :: leave_hanging_faces

  integer, parameter :: MOST_LEVELS = 32 !! of constraints whose masters have constraints themselves
  real(wp), parameter :: OPPOSITE = -0.5_wp  !! largest cosine of the angle between two normals
  real(wp), parameter :: COVERED = 0.9_wp    !! share of a coarse face that fine faces must cover
  real(wp), parameter :: ROOM = 0.1_wp       !! distance of a fine face from the box around a coarse
  !! one, relative to the diagonal of the box, because faces may be curved

  !> What is compared of a face that may bound the body.
  type :: piece_t
    integer :: face = 0
    logical :: hangs = .false.             !! one of its corners follows from other nodes
    integer, allocatable :: corner(:)      !! nodes from which its corners follow
    integer, allocatable :: node(:)        !! nodes from which all its nodes follow
    real(wp) :: area = 0.0_wp              !! [L^2]
    real(wp) :: normal(3) = 0.0_wp         !! integral of the outward normal [L^2]
    real(wp) :: low(3) = 0.0_wp, high(3) = 0.0_wp, centre(3) = 0.0_wp !! [L]
  end type piece_t

contains

  !> Set `bounds` to false for the faces between coarse and fine elements.
  subroutine leave_hanging_faces(file, list, faces)
    type(mesh_file_t), intent(in) :: file
    type(constraint_t), intent(in) :: list !! with node numbers of the file
    type(faces_t), intent(inout) :: faces
    type(piece_t), allocatable :: piece(:)
    integer, allocatable :: mark(:), master(:), head(:), next(:), owner(:)
    logical, allocatable :: named(:)
    real(wp), allocatable :: cover(:)
    integer :: f, i, j, k, n

    if (list%n == 0) return
    allocate (mark(file%nnode), source=0)
    master = [(find(file%number, list%master(i)), i=1, list%first(list%n + 1) - 1)]
    do i = 1, list%n
      n = find(file%number, list%slave(i))
      if (n == 0 .or. any(master(list%first(i):list%first(i + 1) - 1) == 0)) cycle ! an error later
      mark(n) = i
    end do
    allocate (named(file%nnode), source=.false.) ! from these nodes follow those that hang
    do i = 1, list%n
      do j = list%first(i), list%first(i + 1) - 1
        if (master(j) > 0) named(master(j)) = .true.
      end do
      n = find(file%number, list%slave(i))
      if (n > 0) named(n) = .true.
    end do
    n = 0
    allocate (piece(count(faces%bounds)))
    do f = 1, faces%n
      if (.not. faces%bounds(f)) cycle
      if (count(named(pack(faces%corner(:, f), faces%corner(:, f) > 0))) < 2) cycle
      n = n + 1
      call describe(file, list, master, mark, faces, f, piece(n))
    end do
    if (.not. any(piece(:n)%hangs)) return
    allocate (head(file%nnode), source=0) ! for each node the faces whose nodes follow from it
    k = sum([(size(piece(i)%node), i=1, n)])
    allocate (next(k), owner(k))
    allocate (cover(n), source=0.0_wp)
    k = 0
    do i = 1, n
      do j = 1, size(piece(i)%node)
        k = k + 1
        next(k) = head(piece(i)%node(j))
        owner(k) = i
        head(piece(i)%node(j)) = k
      end do
    end do
    do i = 1, n
      if (.not. piece(i)%hangs .or. size(piece(i)%corner) == 0) cycle
      k = head(piece(i)%corner(1))
      do while (k > 0)
        j = owner(k)
        if (is_on(piece(i), piece(j))) then
          faces%bounds(piece(i)%face) = .false.
          cover(j) = cover(j) + piece(i)%area
          exit
        end if
        k = next(k)
      end do
    end do
    do j = 1, n
      if (cover(j) > COVERED*piece(j)%area) faces%bounds(piece(j)%face) = .false.
    end do
  end subroutine leave_hanging_faces

  !> Does a fine face lie on a coarse one of the other side?
  pure logical function is_on(fine, coarse) result(on)
    type(piece_t), intent(in) :: fine, coarse
    real(wp) :: room_around
    integer :: i

    on = fine%area < coarse%area .and. dot_product(fine%normal, coarse%normal) &
         < OPPOSITE*norm2(fine%normal)*norm2(coarse%normal)
    if (.not. on) return
    room_around = ROOM*norm2(coarse%high - coarse%low)
    on = all(fine%centre > coarse%low - room_around .and. fine%centre < coarse%high + room_around)
    if (on) on = all([(find(coarse%node, fine%corner(i)) > 0, i=1, size(fine%corner))])
  end function is_on

  subroutine describe(file, list, master, mark, faces, f, piece)
    type(mesh_file_t), intent(in) :: file
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: master(:)       !! indices of the masters of all constraints
    integer, intent(in) :: mark(:)         !! (nnode) constraint of each node; 0: none
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: f
    type(piece_t), intent(out) :: piece
    integer, allocatable :: corner(:), node(:)

    piece%face = f
    corner = pack(faces%corner(:, f), faces%corner(:, f) > 0)
    piece%hangs = any(mark(corner) > 0)
    piece%corner = origins(list, master, mark, corner)
    associate (s => faces%side(f), e => faces%elem(f))
      associate (topology => file%shapes(file%shape(e))%topology)
        allocate (node, source=topology%node(topology%first(s):topology%first(s + 1) - 1))
      end associate
      piece%node = origins(list, master, mark, file%node(file%first(e) - 1 + node))
    end associate
    call measure_face(file, faces, f, piece%area, piece%normal)
    associate (x => file%x(:, corner))
      piece%low = minval(x, 2)
      piece%high = maxval(x, 2)
      piece%centre = sum(x, 2)/size(corner)
    end associate
  end subroutine describe

  !> The nodes from which the given ones follow in the end; none if constraints form a circle.
  pure function origins(list, master, mark, node) result(origin)
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: master(:), mark(:), node(:)
    integer, allocatable :: origin(:) !! in ascending order
    integer, allocatable :: more(:)
    integer :: i, level

    origin = unique(node)
    do level = 1, MOST_LEVELS
      if (all(mark(origin) == 0)) return
      more = pack(origin, mark(origin) == 0)
      do i = 1, size(origin)
        associate (m => mark(origin(i)))
          if (m > 0) more = [more, master(list%first(m):list%first(m + 1) - 1)]
        end associate
      end do
      origin = unique(more)
    end do
    origin = [integer ::]
  end function origins

end module mesh_hanging
