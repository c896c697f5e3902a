!> NURBS surfaces of G+Smo files, by Bezier extraction element by element.
module spline_nurbs
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: quoted
  use bspline, only: extraction
  use nurbs, only: nurbs_t
  use patch_gismo, only: read_gismo
  use patch_nurbs, only: check_nurbs
  use patch_text, only: text_t
  use spline_surface, only: spline_surface_t, start_surface, add_point, add_element, &
                            finish_surface
  implicit none
  private
  public :: read_nurbs

contains

  !> The surface with id `name`, or the only one.
  subroutine read_nurbs(text, name, surface, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(nurbs_t) :: patch
    real(wp), allocatable :: c1(:, :, :), c2(:, :, :)
    integer, allocatable :: first1(:), first2(:)
    integer :: i, j

    call read_gismo(text, name, 2, patch, error)
    if (allocated(error)) return
    call check_nurbs(patch, 2, quoted(text%path), text%place, error)
    if (allocated(error)) return
    call extraction(patch%dir(1), c1, first1)
    call extraction(patch%dir(2), c2, first2)
    call start_surface(size(patch%cp, 2)*size(patch%cp, 3), size(first1)*size(first2), surface)
    do j = 1, size(patch%cp, 3)
      do i = 1, size(patch%cp, 2)
        associate (h => patch%cp(:, i, j, 1))
          call add_point(text, [h(:3)/h(4), h(4)], surface, error)
        end associate
        if (allocated(error)) return
      end do
    end do
    do j = 1, size(first2)
      do i = 1, size(first1)
        call add_product(text, c1(:, :, i), c2(:, :, j), first1(i), first2(j), &
                         size(patch%cp, 2), surface, error)
        if (allocated(error)) return
      end do
    end do
    call finish_surface(text, surface, error)
  end subroutine read_nurbs

  !> One pair of spans.
  subroutine add_product(text, c1, c2, first1, first2, n, surface, error)
    type(text_t), intent(in) :: text
    real(wp), intent(in) :: c1(:, :), c2(:, :) !! operators of the directions
    integer, intent(in) :: first1, first2      !! their first functions
    integer, intent(in) :: n                   !! control points in direction 1
    type(spline_surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: c(size(c1, 1)*size(c2, 1), size(c1, 1)*size(c2, 1))
    integer :: node(size(c1, 1)*size(c2, 1)), i, j, k, l, p

    p = size(c1, 1)
    do j = 1, size(c2, 1)
      do i = 1, p
        node(i + p*(j - 1)) = first1 + i - 1 + n*(first2 + j - 2)
        do l = 1, size(c2, 1)
          do k = 1, p
            c(i + p*(j - 1), k + p*(l - 1)) = c1(i, k)*c2(j, l)
          end do
        end do
      end do
    end do
    call add_element(text, [p - 1, size(c2, 1) - 1], node, c, surface, error)
  end subroutine add_product

end module spline_nurbs
