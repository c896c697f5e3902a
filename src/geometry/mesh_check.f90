!> Elements of a mesh file: shapes that can be solved for, of positive volume everywhere.
module mesh_check
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_sort, only: unique
  use base_text, only: to_text, quoted
  use element_type, only: element_t, cell_t, rule_t
  use mesh_file, only: mesh_file_t, SHAPE
  use format_text, only: text_t, fail_in_file
  use tensor, only: det3
  implicit none
  private
  public :: check_shapes, check_elements

  !> A volume below this share of the cube of the element's size is none: rounding of the file.
  real(wp), parameter :: FLAT = 1.0e-12_wp

contains

  !> There is a body, and all its shapes are known.
  subroutine check_shapes(file, rows, text, error)
    type(mesh_file_t), intent(in) :: file
    type(element_t), intent(in) :: rows(:)   !! of each entry of SHAPE
    type(text_t), intent(inout) :: text
    type(error_t), allocatable, intent(out) :: error
    integer :: e

    do e = 1, file%nelem
      if (.not. file%solid(e) .or. rows(file%shape(e))%name /= '') cycle
      text%at = file%spot(e)
      call fail_in_file(text, 'element '//to_text(file%label(e))//' is a ' &
                    //trim(SHAPE(file%shape(e))%name)//' of ' &
                    //to_text(SHAPE(file%shape(e))%nen)//' nodes', error, &
                    'there are tetrahedra of 4 and 10 nodes, pyramids of 5, wedges of 6 and ' &
                    //'hexahedra of 8 and 27')
      return
    end do
    if (any(file%solid)) return
    text%at = 0
    call fail_in_file(text, 'the file has no elements of a volume', error, &
                  'in Gmsh: mesh in 3 dimensions, and give the volume a physical group if ' &
                  //'anything has one')
  end subroutine check_shapes

  !> Nodes of an element differ, and its map is right-handed at all integration points.
  subroutine check_elements(file, rows, text, volume, error)
    type(mesh_file_t), intent(in) :: file
    type(element_t), intent(in) :: rows(:)
    type(text_t), intent(inout) :: text
    real(wp), intent(out) :: volume          !! of the body [L^3]
    type(error_t), allocatable, intent(out) :: error
    integer :: kind

    volume = 0.0_wp
    do kind = 1, size(SHAPE)
      if (rows(kind)%name == '') cycle
      if (.not. any(file%shape(:file%nelem) == kind)) cycle
      call check_kind(file, kind, rows(kind), text, volume, error)
      if (allocated(error)) return
    end do
  end subroutine check_elements

  subroutine check_kind(file, kind, row, text, volume, error)
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: kind
    type(element_t), intent(in) :: row
    type(text_t), intent(inout) :: text
    real(wp), intent(inout) :: volume
    type(error_t), allocatable, intent(out) :: error
    type(cell_t) :: cell
    type(rule_t) :: rule
    real(wp) :: x(3, SHAPE(kind)%nen), shp(SHAPE(kind)%nen), least, det
    real(wp), allocatable :: dshp(:, :, :), full(:)
    integer :: e, q

    cell%degree = row%degree
    call row%rule(cell, 0, 0, rule)
    allocate (dshp(3, SHAPE(kind)%nen, rule%nq), full(rule%nq))
    do q = 1, rule%nq
      call row%functions(cell, rule%xi(:, q), shp, dshp(:, :, q))
      full(q) = abs(det3(matmul(parent(kind), transpose(dshp(:, :, q)))))
    end do
    do e = 1, file%nelem
      if (file%shape(e) /= kind .or. .not. file%solid(e)) cycle
      associate (node => file%node(file%first(e):file%first(e + 1) - 1))
        text%at = file%spot(e)
        if (size(unique(node)) < size(node)) then
          call fail_in_file(text, 'element '//to_text(file%label(e))//' has a node twice', error, &
                        'collapsed hexahedra are wedges, pyramids or tetrahedra: write them so')
          return
        end if
        x = file%x(:, node)
      end associate
      least = huge(least)
      do q = 1, rule%nq
        det = det3(matmul(x, transpose(dshp(:, :, q))))
        least = min(least, det/full(q))
        volume = volume + rule%wgt(q)*det
      end do
      if (least > FLAT*extent(x)**3) cycle
      call complain_volume(file, e, least, extent(x), text, error)
      return
    end do
  end subroutine check_kind

  !> Size of an element.
  pure real(wp) function extent(x)
    real(wp), intent(in) :: x(:, :)

    extent = maxval(maxval(x, 2) - minval(x, 2))
  end function extent

  !> Nodes that measure the map of the parent: collapsed elements have small determinants where they
  !! are collapsed.
  pure function parent(kind) result(x)
    integer, intent(in) :: kind
    real(wp) :: x(3, SHAPE(kind)%nen)
    integer :: i, j, k, n

    select case (SHAPE(kind)%nen)
    case (4, 10)
      x(:, :4) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 4])
      if (SHAPE(kind)%nen == 10) x(:, 5:) = 0.5_wp*(x(:, [1, 2, 3, 1, 2, 3]) &
                                                    + x(:, [2, 3, 1, 4, 4, 4]))
    case (27)
      n = 0
      do k = 0, 2
        do j = 0, 2
          do i = 0, 2
            n = n + 1
            x(:, n) = 0.5_wp*[i, j, k]
          end do
        end do
      end do
    case (6)
      x = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1], [3, 6])
    case default
      x(:, :4) = reshape([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], [3, 4])
      x(:, 5:) = spread([0.0_wp, 0.0_wp, 1.0_wp], 2, SHAPE(kind)%nen - 4)
      if (SHAPE(kind)%nen == 8) x(:2, 5:) = x(:2, :4)
    end select
  end function parent

  subroutine complain_volume(file, e, least, size_of, text, error)
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: e
    real(wp), intent(in) :: least, size_of
    type(text_t), intent(in) :: text
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name

    name = trim(SHAPE(file%shape(e))%name)//' '//to_text(file%label(e))
    if (least > -FLAT*size_of**3) then
      call fail_in_file(text, name//' has no volume', error, &
                    'its nodes lie in one plane: remove it, or mesh again')
    else
      call fail_in_file(text, name//' is inverted', error, &
                    'its nodes go round the other way, or it is folded: in Gmsh ' &
                    //'ReorientMesh Volume, or Mesh.ElementOrder = 1 where a curved one is folded')
    end if
  end subroutine complain_volume

end module mesh_check
